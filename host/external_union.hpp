#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/mass.hpp"
#include "host/box_file.hpp"
#include "host/engine.hpp"
#include "host/files.hpp"

namespace boxunion {

/// How much memory a union may take, and where the rest goes.
struct Budget {
  /// Of the whole process on the native device: what boxunion allocates, its code and its threads. What the
  /// drivers of other devices allocate, as far as boxunion does not ask for it, is beyond it.
  std::uint64_t bytes = 0;
  std::string scratch;           ///< folder for nameless files
  std::uint64_t slab_boxes = 0;  ///< if not 0, the most boxes of a slab, even where more would fit
};

/// The union of more boxes than memory holds, by distribution sweeping.
///
/// One pass over the boxes finds axes and where to cut, one more puts them into slabs on disk, as many as to
/// make each fit; a slab that is still too large is cut again, along any axis. Then each slab goes through
/// the engine, which keeps what the slab owns, the points lo <= p < hi. All devices and methods, the result
/// the same to the last bit as in memory.
class ExternalUnion {
 public:
  /// Reads the boxes once. All arguments must outlive the union. Throws Error(input) for the first invalid
  /// box, Error(resources) for a budget too small for any run.
  ExternalUnion(const BoxFile& boxes, const Options& options, const Budget& budget, Report& report);
  ~ExternalUnion();
  ExternalUnion(const ExternalUnion&) = delete;
  ExternalUnion& operator=(const ExternalUnion&) = delete;

  std::uint64_t degenerate_boxes() const;
  /// Slabs that went through the engine so far.
  std::uint64_t slabs() const;
  /// Memory that the union would take all at once, as vertices, with `bytes_a_vertex` for each of them.
  std::uint64_t bytes_in_memory(std::uint64_t vertices, std::uint64_t bytes_a_vertex) const;

  /// Throws Error(resources) where boxes lie too deep over each other for slabs that fit, or the disk is
  /// full; Error(interrupted); and as boxunion::measure does.
  MassProperties measure();

  /// Takes vertices in order, block by block.
  using VertexBlocks = std::function<void(std::span<const PlacedVertex>)>;
  /// Finds the vertices. When their number is known it calls begin(number), which gives what takes them,
  /// sorted by z, then y, then x. Throws as measure does.
  void vertices(const std::function<VertexBlocks(std::uint64_t)>& begin);

 private:
  class Run;
  std::unique_ptr<Run> run_;
};

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "boxunion/external.hpp"
#include "boxunion/union.hpp"
#include "core/base/radix_sort.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/files/box_file.hpp"
#include "host/files/scratch.hpp"

namespace boxunion {

/// A vertex on disk. Its coordinates C are ordinals if all axes of the union are lattices, otherwise
/// ordered_bits, which need no axes.
template <class C>
struct ExternalVertex {
  std::array<C, 3> at;  ///< x, y, z
  C mask;               ///< octant mask; as wide as the coordinates, so that there is no padding

  /// By z, then y, then x, like vertices.
  friend bool operator<(const ExternalVertex& a, const ExternalVertex& b) {
    if (a.at[2] != b.at[2]) return a.at[2] < b.at[2];
    if (a.at[1] != b.at[1]) return a.at[1] < b.at[1];
    return a.at[0] < b.at[0];
  }
};

/// The number of such a coordinate on an axis.
inline double external_coordinate(const Axis& axis, std::uint32_t ordinal) {
  return axis.coordinate(ordinal);
}
inline double external_coordinate(const Axis&, std::uint64_t bits) {
  return from_ordered_bits(bits);
}

/// The union of more boxes than memory holds, by distribution sweeping.
///
/// One pass over the boxes finds the axes and where to cut. A second pass puts the boxes into slabs on disk,
/// so many that each fits. A slab that is still too large is cut again, along any axis. Then each slab goes
/// through the engine, which keeps what the slab owns, the points lo <= p < hi. This works with all devices
/// and methods, and the result is the same to the last bit as in memory.
class ExternalUnion {
 public:
  /// Reads the boxes once. All arguments must outlive the union. Throws Error(input) for the first invalid
  /// box, Error(resources) for a budget too small for any run.
  ExternalUnion(const BoxFile& boxes, const Options& options, const Budget& budget, Report& report);
  ~ExternalUnion();
  ExternalUnion(const ExternalUnion&) = delete;
  ExternalUnion& operator=(const ExternalUnion&) = delete;

  std::uint64_t degenerate_boxes() const;
  /// The axes of the union, if all are lattices. Otherwise, axes that are no lattices have no ordinals:
  /// count() is 0.
  const Axes& axes() const;
  /// Calls f(C{}) with the type C of ExternalVertex's coordinates. f is a template.
  template <class F>
  void with_coordinates(F&& f) const {
    if (is_lattice())
      f(std::uint32_t{});
    else
      f(std::uint64_t{});
  }
  /// The number of slabs that went through the engine so far.
  std::uint64_t slabs() const;

  /// The mass properties. Throws Error(resources) if boxes overlap too deeply for slabs that fit, or the disk
  /// is full; Error(interrupted); and as boxunion::measure does. Report::statistics, if requested, are those
  /// from memory. Report::cells are those of all slabs.
  MassProperties measure();

  /// The part of the budget that is left for boxes, vertices and models of them.
  std::uint64_t bytes() const;
  /// The budget of a run that would leave so much.
  std::uint64_t budget_for(std::uint64_t bytes) const;
  /// A new file in the folder of the budget.
  ScratchFile scratch_file() const;

  /// Sets the number of passes over the results that follow the union. Each pass has the same share of the
  /// progress.
  void expect_passes(unsigned passes);
  /// begin_pass() begins the next pass, over `count` vertices or other elements. advance() adds to the number
  /// of those done.
  void begin_pass(std::uint64_t count);
  void advance(std::uint64_t count);

  /// Finds the vertices and passes them to take(), batch by batch in any order, from several threads at once.
  /// Takes about `bytes` of memory. C must be that of with_coordinates. Throws as measure does.
  template <class C>
  void unite(std::uint64_t bytes, const std::function<void(std::span<const ExternalVertex<C>>)>& take);

  /// Receives vertices in order, block by block.
  using VertexBlocks = std::function<void(std::span<const PlacedVertex>)>;
  /// Finds the vertices. When their number is known, calls begin(number). Passes the vertices, sorted by z,
  /// then y, then x, to the function that begin returns. Throws as measure does.
  void vertices(const std::function<VertexBlocks(std::uint64_t)>& begin);

 private:
  bool is_lattice() const;

  class Run;
  std::unique_ptr<Run> run_;
};

}  // namespace boxunion

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

/// A vertex outside of memory. Its coordinates C are ordinals where all axes of the union are lattices, else
/// ordered_bits, which need no axes.
template <class C>
struct ExternalVertex {
  std::array<C, 3> at;  ///< x, y, z
  C mask;               ///< octant mask; as wide as they are, so that no bytes between are left unset

  /// By z, then y, then x, as vertices sort.
  friend bool operator<(const ExternalVertex& a, const ExternalVertex& b) {
    if (a.at[2] != b.at[2]) return a.at[2] < b.at[2];
    if (a.at[1] != b.at[1]) return a.at[1] < b.at[1];
    return a.at[0] < b.at[0];
  }
};

/// The number that such a coordinate on an axis stands for.
inline double external_coordinate(const Axis& axis, std::uint32_t ordinal) {
  return axis.coordinate(ordinal);
}
inline double external_coordinate(const Axis&, std::uint64_t bits) {
  return from_ordered_bits(bits);
}

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
  /// Those of the union where all are lattices. Else the others have no ordinals: count() is 0.
  const Axes& axes() const;
  /// Calls f(C{}) with the type of ExternalVertex's coordinates; f is a template.
  template <class F>
  void with_coordinates(F&& f) const {
    if (is_lattice())
      f(std::uint32_t{});
    else
      f(std::uint64_t{});
  }
  /// Slabs that went through the engine so far.
  std::uint64_t slabs() const;

  /// Throws Error(resources) where boxes lie too deep over each other for slabs that fit, or the disk is
  /// full; Error(interrupted); and as boxunion::measure does. Report::statistics, if asked for, are those
  /// from memory, Report::cells those of all slabs.
  MassProperties measure();

  /// What is left of the budget for boxes, vertices and whatever is made of them.
  std::uint64_t bytes() const;
  /// The budget that a run would need to leave so much.
  std::uint64_t budget_for(std::uint64_t bytes) const;
  /// A new file in the folder of the budget.
  ScratchFile scratch_file() const;

  /// Says how many passes over what it finds follow the union: all share in the options' progress alike.
  void expect_passes(unsigned passes);
  /// The next pass, over so many vertices or whatever it counts; and how many more of them are done.
  void begin_pass(std::uint64_t count);
  void advance(std::uint64_t count);

  /// Finds the vertices and gives them to take(), batch by batch in any order, from several threads at once;
  /// takes about so many bytes of memory. C is that of with_coordinates. Throws as measure does.
  template <class C>
  void unite(std::uint64_t bytes, const std::function<void(std::span<const ExternalVertex<C>>)>& take);

  /// Takes vertices in order, block by block.
  using VertexBlocks = std::function<void(std::span<const PlacedVertex>)>;
  /// Finds the vertices. When their number is known it calls begin(number), which gives what takes them,
  /// sorted by z, then y, then x. Throws as measure does.
  void vertices(const std::function<VertexBlocks(std::uint64_t)>& begin);

 private:
  bool is_lattice() const;

  class Run;
  std::unique_ptr<Run> run_;
};

}  // namespace boxunion

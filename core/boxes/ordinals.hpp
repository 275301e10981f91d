#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "boxunion/axis.hpp"
#include "boxunion/box.hpp"
#include "boxunion/rectangle.hpp"
#include "core/base/memory.hpp"

namespace boxunion {

/// Finds the axes of valid boxes in parallel. Degenerate boxes take part (their coordinates may stretch a
/// lattice, which is harmless). Throws Error(resources) as Axis::rank does.
Axes make_axes(const BoxSet& boxes);

/// What decides which axes of boxes are lattices, gathered set by set.
class LatticeScan {
 public:
  /// Takes valid boxes in. Parallel.
  void add(const BoxSet& boxes);
  void add(const RectangleSet& rectangles);
  void join(const LatticeScan& other);
  /// The axes that are lattices for everything taken in; the others have no ordinals: count() is 0.
  Axes axes() const;
  /// The same of rectangles.
  PlaneAxes plane_axes() const;

 private:
  /// What the coordinates of one axis have in common.
  struct Extent {
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double lo = kInfinity, hi = -kInfinity;
    double unit =
        kInfinity;  // the greatest power of two that divides them all; infinity if they are all zero
    void join(const Extent& other);
  };
  // of boxes in `kAxes` dimensions, lower corner first
  template <unsigned kAxes>
  static LatticeScan scan(const std::array<double, 2 * kAxes>* boxes, std::size_t count);
  template <unsigned kAxes>
  static LatticeScan scan(const std::array<std::int32_t, 2 * kAxes>* boxes, std::size_t count);
  template <unsigned kAxes, class Set>
  static LatticeScan scan(const Set& set);
  static Axis lattice_of(const Extent& extent);

  std::array<Extent, 3> extents_;  // the last one without coordinates if there are only rectangles
};

/// The axes of all boxes of some sets if all three are lattices, found in one streaming pass; nothing
/// otherwise.
std::optional<Axes> find_lattices(std::span<const BoxSet> sets);

/// Ranks on every axis whatever the coordinates are: the slower of the two exact maps, used by tests.
Axes make_rank_axes(const BoxSet& boxes);

/// The boxes as ordinals, in the same order, without the degenerate ones. Parallel; a binary search for every
/// coordinate on a rank axis.
std::vector<OrdinalBox> ordinal_boxes(const BoxSet& boxes, const Axes& axes);

/// Sets of boxes in ordinals, and what these stand for.
struct Ordinals {
  Axes axes;
  std::vector<OrdinalBox> boxes;  ///< set after set
  std::vector<std::size_t> ends;  ///< of each set in `boxes`
  /// Where the union is wanted, if not everywhere: at the points lo <= p < hi. No box reaches further than
  /// from lo - 1 to hi.
  std::optional<OrdinalBox> region = std::nullopt;
};

/// Finds the axes of valid boxes and turns the boxes into ordinals, in the same order and without the
/// degenerate ones, whose coordinates have no ordinal on a rank axis. Does in parallel, and by the same
/// rules, what make_axes and ordinal_boxes do, but on a rank axis one sort gives every ordinal. Beside its
/// result it holds 32 bytes for each of the 2 * boxes.size() coordinates of one rank axis. Throws
/// Error(resources) as Axis::rank does.
Ordinals make_ordinals(const BoxSet& boxes);

/// The same for several sets that share their axes; `sets` together hold as many boxes as one would.
Ordinals make_ordinals(std::span<const BoxSet> sets);

/// The ordinals of several sets on axes that they share.
Ordinals ordinal_boxes(std::span<const BoxSet> sets, const Axes& axes);

/// A rectangle in ordinals.
struct OrdinalRectangle {
  std::array<std::uint32_t, 2> lo, hi;
  friend bool operator==(const OrdinalRectangle&, const OrdinalRectangle&) = default;
};

/// Rectangles in ordinals, and what these stand for.
struct PlaneOrdinals {
  PlaneAxes axes;
  Array<OrdinalRectangle> rectangles;
};

/// Finds the axes of valid rectangles and turns them into ordinals as make_ordinals does for boxes.
PlaneOrdinals make_ordinals(const RectangleSet& rectangles);

/// The distinct ordinals of the boxes on one axis, sorted.
std::vector<std::uint32_t> distinct_ordinals(std::span<const OrdinalBox> boxes, int axis);

/// Replaces the ordinals on one axis by their positions, from `first` on, among the sorted `distinct` ones.
void replace_by_positions(std::span<OrdinalBox> boxes, int axis, std::span<const std::uint32_t> distinct,
                          std::uint32_t first);

}  // namespace boxunion

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

/// Finds the axes of valid boxes, in parallel. Degenerate boxes take part; they may extend a lattice, which
/// is harmless. Throws Error(resources) as Axis::rank does.
Axes make_axes(const BoxSet& boxes);

/// Finds which axes of boxes are lattices, from one set after the other.
class LatticeScan {
 public:
  /// Adds valid boxes. Parallel.
  void add(const BoxSet& boxes);
  void add(const RectangleSet& rectangles);
  void join(const LatticeScan& other);
  /// The axes that are lattices for everything added. The others have no ordinals: count() is 0.
  Axes axes() const;
  /// The same for rectangles.
  PlaneAxes plane_axes() const;

 private:
  /// The common properties of the coordinates of an axis.
  struct Extent {
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double lo = kInfinity, hi = -kInfinity;
    double unit = kInfinity;  // greatest power of two that divides all; infinity if all are zero
    void join(const Extent& other);
  };
  // boxes of `kAxes` dimensions, lower corner first
  template <unsigned kAxes>
  static LatticeScan scan(const std::array<double, 2 * kAxes>* boxes, std::size_t count);
  template <unsigned kAxes>
  static LatticeScan scan(const std::array<std::int32_t, 2 * kAxes>* boxes, std::size_t count);
  template <unsigned kAxes, class Set>
  static LatticeScan scan(const Set& set);
  static Axis lattice_of(const Extent& extent);

  std::array<Extent, 3> extents_;  // the last has no coordinates if there are only rectangles
};

/// The axes of all boxes of some sets if all three are lattices, otherwise nothing. One streaming pass.
std::optional<Axes> find_lattices(std::span<const BoxSet> sets);

/// Ranks on every axis, for any coordinates. The slower of the two exact maps, used by tests.
Axes make_rank_axes(const BoxSet& boxes);

/// The boxes in ordinals, in the same order, without degenerate boxes. Parallel. Takes a binary search for
/// every coordinate on a rank axis.
std::vector<OrdinalBox> ordinal_boxes(const BoxSet& boxes, const Axes& axes);

/// Sets of boxes in ordinals, and their axes.
struct Ordinals {
  Axes axes;
  std::vector<OrdinalBox> boxes;  ///< set after set
  std::vector<std::size_t> ends;  ///< of each set in `boxes`
  /// The region in which the union is wanted, if not everywhere: the points lo <= p < hi. No box may reach
  /// beyond lo - 1 .. hi.
  std::optional<OrdinalBox> region = std::nullopt;
};

/// Finds the axes of valid boxes, and converts the boxes to ordinals in the same order. Leaves out degenerate
/// boxes, whose coordinates have no ordinal on a rank axis. The result is that of make_axes and
/// ordinal_boxes, but one sort gives all ordinals of a rank axis. Parallel. Beside its result, it holds 32
/// bytes for each of the 2 * boxes.size() coordinates of a rank axis. Throws Error(resources) as Axis::rank
/// does.
Ordinals make_ordinals(const BoxSet& boxes);

/// The same for several sets that share their axes. The limit of boxes holds for all sets together.
Ordinals make_ordinals(std::span<const BoxSet> sets);

/// The ordinals of several sets on shared axes.
Ordinals ordinal_boxes(std::span<const BoxSet> sets, const Axes& axes);

/// A rectangle in ordinals.
struct OrdinalRectangle {
  std::array<std::uint32_t, 2> lo, hi;
  friend bool operator==(const OrdinalRectangle&, const OrdinalRectangle&) = default;
};

/// Rectangles in ordinals, and their axes.
struct PlaneOrdinals {
  PlaneAxes axes;
  Array<OrdinalRectangle> rectangles;
};

/// Finds the axes of valid rectangles and converts the rectangles to ordinals, as make_ordinals does for
/// boxes.
PlaneOrdinals make_ordinals(const RectangleSet& rectangles);

/// The sorted distinct ordinals of the boxes on an axis.
std::vector<std::uint32_t> distinct_ordinals(std::span<const OrdinalBox> boxes, int axis);

/// Replaces the ordinals on an axis by their positions, counted from `first`, in the sorted `distinct`
/// ordinals.
void replace_by_positions(std::span<OrdinalBox> boxes, int axis, std::span<const std::uint32_t> distinct,
                          std::uint32_t first);

}  // namespace boxunion

#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/base/memory.hpp"
#include "core/boxes/box.hpp"

namespace boxunion {

class RectangleSet;

/// The ordinals of a lattice as a function of its coordinates.
class LatticeOrdinals {
 public:
  LatticeOrdinals() = default;
  /// Of the lattice (base + ordinal) * 2^exponent.
  LatticeOrdinals(std::int64_t base, int exponent)
      : scale_before_(std::ldexp(1.0, -(exponent / 2))),
        scale_after_(std::ldexp(1.0, -(exponent - exponent / 2))),
        first_(std::ldexp(double(base + 1), exponent - exponent / 2)) {}

  // A scaled coordinate minus the scaled first one is the ordinal - 1; the addition leaves it in the low bits
  // of the significand, whence it comes without a conversion (so that loops vectorise). Every step is exact:
  // 2^exponent divides both coordinates and fewer than 2^32 steps lie between them. The scale goes half
  // before and half after the subtraction because 2^-exponent may overflow (and so may the plain difference).
  std::uint32_t operator()(double coordinate) const {
    const double steps = (coordinate * scale_before_ - first_) * scale_after_;
    return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(steps + (0x1p52 + 1)));
  }

 private:
  double scale_before_ = 1, scale_after_ = 1, first_ = 0;
};

/// Ordinals of one axis: an exact, order-preserving map between the coordinates that occur in a set of boxes
/// and the integers 1 .. 2^32 - 2 ("only comparison and assignment", López Monterde et al., section 1). All
/// topology works on ordinals; kOrdinalMin and kOrdinalMax lie below and above every one of them.
///
/// - lattice: every coordinate is (base + ordinal) * 2^exponent for one exponent; found in one pass, no sort.
/// - rank: the ordinal is one plus the position among the sorted distinct coordinates.
class Axis {
 public:
  static constexpr std::uint32_t kOrdinalMin = 0, kOrdinalMax = 0xffffffffu;

  /// An axis without coordinates.
  Axis() = default;
  /// A lattice of `count` ordinals from 1 on; ordinal 1 must be a coordinate that a double can hold.
  static Axis lattice(std::int64_t base, int exponent, std::uint32_t count);
  /// Ranks of sorted distinct finite coordinates. Throws Error(resources) if there are more than 2^32 - 2.
  static Axis rank(std::vector<double> coordinates);

  bool is_lattice() const { return ranks_.empty(); }
  /// Ordinals that may occur are 1 .. count().
  std::uint32_t count() const { return count_; }
  std::int64_t base() const { return base_; }
  int exponent() const { return exponent_; }

  /// The coordinate of an ordinal that occurs in the boxes; exact.
  double coordinate(std::uint32_t ordinal) const {
    return is_lattice() ? lattice_coordinate(ordinal) : ranks_[ordinal - 1];
  }
  /// Of a lattice, the ordinals of its coordinates.
  const LatticeOrdinals& lattice_ordinals() const { return lattice_ordinals_; }
  /// The ordinal of a coordinate that occurs in the boxes.
  std::uint32_t ordinal(double coordinate) const {
    return is_lattice() ? lattice_ordinals_(coordinate) : rank_ordinal(coordinate);
  }

  friend bool operator==(const Axis& a, const Axis& b) {
    return a.base_ == b.base_ && a.exponent_ == b.exponent_ && a.count_ == b.count_ && a.ranks_ == b.ranks_;
  }

 private:
  std::uint32_t rank_ordinal(double coordinate) const;
  double lattice_coordinate(std::uint32_t ordinal) const;

  std::int64_t base_ = 0;
  int exponent_ = 0;
  std::uint32_t count_ = 0;
  LatticeOrdinals lattice_ordinals_;
  std::vector<double> ranks_;
};

/// An axis as a function: what Axis::coordinate gives, without a call to the mathematical library.
class Coordinates {
 public:
  explicit Coordinates(const Axis& axis) : axis_(&axis), step_(std::ldexp(1.0, axis.exponent())) {}
  double operator()(std::uint32_t ordinal) const {
    return axis_->is_lattice() ? double(axis_->base() + ordinal) * step_ : axis_->coordinate(ordinal);
  }

 private:
  const Axis* axis_;
  double step_;
};

/// The three axes of a set of boxes, each a lattice where the coordinates allow it.
using Axes = std::array<Axis, 3>;
/// The two of rectangles.
using PlaneAxes = std::array<Axis, 2>;

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

/// A box in ordinals.
struct OrdinalBox {
  std::array<std::uint32_t, 3> lo, hi;

  /// As a region, does it own a point: lo <= p < hi?
  bool owns(const std::array<std::uint32_t, 3>& p) const {
    return lo[0] <= p[0] && p[0] < hi[0] && lo[1] <= p[1] && p[1] < hi[1] && lo[2] <= p[2] && p[2] < hi[2];
  }
  friend bool operator==(const OrdinalBox&, const OrdinalBox&) = default;
};

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

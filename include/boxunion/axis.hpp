#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

/// The ordinals of a lattice as a function of its coordinates.
class LatticeOrdinals {
 public:
  LatticeOrdinals() = default;
  /// For the lattice (base + ordinal) * 2^exponent.
  LatticeOrdinals(std::int64_t base, int exponent)
      : scale_before_(std::ldexp(1.0, -(exponent / 2))),
        scale_after_(std::ldexp(1.0, -(exponent - exponent / 2))),
        first_(std::ldexp(double(base + 1), exponent - exponent / 2)) {}

  // The scaled coordinate minus the scaled first one is the ordinal - 1. The addition moves it into the low
  // bits of the significand, where it can be read without a conversion, so that loops vectorize. Every step
  // is exact: 2^exponent divides both coordinates, and fewer than 2^32 steps lie between them. Half of the
  // scale is applied before the subtraction and half after it, because 2^-exponent may overflow, and so may
  // the plain difference.
  std::uint32_t operator()(double coordinate) const {
    const double steps = (coordinate * scale_before_ - first_) * scale_after_;
    return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(steps + (0x1p52 + 1)));
  }

 private:
  double scale_before_ = 1, scale_after_ = 1, first_ = 0;
};

/// The ordinals of an axis: an exact, order-preserving map between the coordinates that occur in a set of
/// boxes and the integers 1 .. 2^32 - 2 ("only comparison and assignment", López Monterde et al., section 1).
/// All topology works on ordinals. kOrdinalMin and kOrdinalMax lie below and above all of them.
///
/// - lattice: every coordinate is (base + ordinal) * 2^exponent for one exponent; found in one pass, without
/// a sort.
/// - rank: the ordinal is one plus the position among the sorted distinct coordinates.
class BOXUNION_API Axis {
 public:
  static constexpr std::uint32_t kOrdinalMin = 0, kOrdinalMax = 0xffffffffu;

  /// An axis without coordinates.
  Axis() = default;
  /// A lattice of `count` ordinals from 1 on. A double must be able to hold the coordinate of ordinal 1.
  static Axis lattice(std::int64_t base, int exponent, std::uint32_t count);
  /// The ranks of sorted distinct finite coordinates. Throws Error(resources) if there are more than 2^32 -
  /// 2.
  static Axis rank(std::vector<double> coordinates);

  bool is_lattice() const { return ranks_.empty(); }
  /// The possible ordinals are 1 .. count().
  std::uint32_t count() const { return count_; }
  std::int64_t base() const { return base_; }
  int exponent() const { return exponent_; }

  /// The exact coordinate of an ordinal that occurs in the boxes.
  double coordinate(std::uint32_t ordinal) const {
    return is_lattice() ? lattice_coordinate(ordinal) : ranks_[ordinal - 1];
  }
  /// The ordinals of a lattice as a function of its coordinates.
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

/// An axis as a function: the same as Axis::coordinate, without a call of the mathematical library.
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

/// The three axes of a set of boxes. Each is a lattice if the coordinates allow it.
using Axes = std::array<Axis, 3>;
/// The two axes of a set of rectangles.
using PlaneAxes = std::array<Axis, 2>;

/// A box in ordinals.
struct OrdinalBox {
  std::array<std::uint32_t, 3> lo, hi;

  /// True if this box, as a region, owns a point: lo <= p < hi.
  bool owns(const std::array<std::uint32_t, 3>& p) const {
    return lo[0] <= p[0] && p[0] < hi[0] && lo[1] <= p[1] && p[1] < hi[1] && lo[2] <= p[2] && p[2] < hi[2];
  }
  friend bool operator==(const OrdinalBox&, const OrdinalBox&) = default;
};

}  // namespace boxunion

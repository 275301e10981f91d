#pragma once

#include <cstdint>
#include <span>

#include "core/face_sweep.hpp"
#include "core/planes.hpp"

namespace boxunion {

/// Sweeps the faces of planes of a solid, see FaceSweep; events refer to positions in the plane.
template <class Interval>
class PlaneSweep {
 public:
  /// Takes a plane normal to `axis`, which must stay.
  void assign(int axis, std::span<const PlaneVertex> plane) {
    axis_ = axis;
    plane_ = plane;
    if (!is_small()) columns_.assign(plane);
  }

  /// Sweeps the faces of a direction (0: towards the axis' positive side, 1: negative).
  template <class Visitor>
  void run(unsigned side, Visitor&& visitor) {
    const auto quadrants = [&](std::size_t i) { return kFaceQuadrants[plane_[i].mask][axis_][side]; };
    if (is_small())
      sweep_.run_small(
          plane_.size(), [&](std::size_t i) { return plane_[i].column; }, quadrants, visitor);
    else
      sweep_.run(
          plane_.size(), columns_.count(), [&](std::size_t i) { return columns_[i]; }, quadrants, visitor);
  }

 private:
  bool is_small() const { return plane_.size() <= FaceSweep<Interval>::kSmall; }

  int axis_ = 0;
  std::span<const PlaneVertex> plane_;
  PlaneColumns columns_;
  FaceSweep<Interval> sweep_;
};

}  // namespace boxunion

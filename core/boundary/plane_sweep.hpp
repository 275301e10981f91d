#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/boundary/face_sweep.hpp"
#include "core/boundary/planes.hpp"

namespace boxunion {

/// Sweeps the faces of planes of a solid; see FaceSweep. Events identify vertices by their positions in the
/// plane.
template <class Interval>
class PlaneSweep {
 public:
  /// Takes a plane normal to `axis`.
  void assign(int axis, std::span<const PlaneVertex> plane) {
    const bool is_small = plane.size() <= FaceSweep<Interval>::kSmall;
    if (!is_small) columns_.assign(plane);
    for (auto& vertices : vertices_)
      if (vertices.size() < plane.size()) vertices.resize(plane.size());
    std::array<SweepVertex*, 2> next = {vertices_[0].data(), vertices_[1].data()};
    for (std::uint32_t i = 0; i < plane.size(); ++i) {
      const std::uint32_t column = is_small ? plane[i].column : columns_[i];
      const auto& quadrants = kFaceQuadrants[plane[i].mask][axis];
      for (unsigned side = 0; side < 2; ++side) {  // branch-free, because the branch would be unpredictable
        *next[side] = {i, column, quadrants[side]};
        next[side] += quadrants[side] != 0;
      }
    }
    for (unsigned side = 0; side < 2; ++side) count_[side] = std::size_t(next[side] - vertices_[side].data());
  }

  /// The vertices of the faces of a direction (0: towards the axis' positive side, 1: negative).
  std::span<const SweepVertex> vertices(unsigned side) const {
    return std::span(vertices_[side]).first(count_[side]);
  }
  /// True if there is one face, a rectangle. Its vertices are then lower left, lower right, upper left, upper
  /// right.
  bool is_rectangle(unsigned side) const {
    const auto& v = vertices_[side];
    return count_[side] == 4 && v[0].quadrants == 1u << right_above && v[1].quadrants == 1u << left_above &&
           v[2].quadrants == 1u << right_below && v[3].quadrants == 1u << left_below;
  }

  /// Sweeps the faces of a direction.
  template <class Visitor>
  void run(unsigned side, Visitor&& visitor) {
    sweep_.run(vertices(side), columns_.count(), visitor);
  }

 private:
  std::array<std::vector<SweepVertex>, 2> vertices_;
  std::array<std::size_t, 2> count_{};
  PlaneColumns columns_;
  FaceSweep<Interval> sweep_;
};

}  // namespace boxunion

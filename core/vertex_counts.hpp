#pragma once

#include <array>
#include <cstdint>

#include "core/fans.hpp"
#include "core/octants.hpp"
#include "core/planes.hpp"

namespace boxunion {

namespace detail {

/// Twice what a vertex adds to the number of triangles that faces are cut into, by octant mask. A face with n
/// points and h holes gives n + 2h - 2 triangles; turning left at a corner is a quarter of an outer loop,
/// turning right a quarter of a hole's.
inline constexpr auto kTwiceTriangles = [] {
  constexpr std::array<std::uint8_t, 16> kCorners = {0, 1, 1, 1, 1, 1, 2, 1, 1, 2, 1, 1, 1, 1, 1, 0};
  constexpr std::array<std::int8_t, 16> kTurns = {0, 1, 1, 0, 1, 0, 2, -1, 1, 2, 0, -1, 0, -1, -1, 0};
  std::array<std::int8_t, 256> table{};
  for (unsigned mask = 0; mask < 256; ++mask)
    for (int axis = 0; axis < 3; ++axis)
      for (const std::uint8_t quadrants : kFaceQuadrants[mask][std::size_t(axis)])
        table[mask] = std::int8_t(table[mask] + 2 * kCorners[quadrants] - kTurns[quadrants]);
  return table;
}();

}  // namespace detail

/// What the vertices alone say about how much a boundary has: sums over their octant masks.
class VertexCounts {
 public:
  void add(unsigned mask) {
    ++vertices;
    for (const int direction : {0, 2, 4}) {  // each edge at its lower end
      edges += kOctants[mask].edges[direction] != 0;
      nonmanifold_edges += kOctants[mask].edges[direction] == 2;
    }
    fans += kFans[mask].count;
    twice_triangles_ += detail::kTwiceTriangles[mask];
  }

  std::uint64_t vertices = 0, edges = 0, nonmanifold_edges = 0;
  std::uint64_t fans = 0;
  /// Of the triangulated faces where contacts are kept; each midpoint of a split edge adds two.
  std::uint64_t triangles() const { return static_cast<std::uint64_t>(twice_triangles_ / 2); }

 private:
  std::int64_t twice_triangles_ = 0;
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/octants.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/ranks.hpp"
#include "core/solid/solid_sink.hpp"

namespace boxunion {

/// A vertex of a plane. Columns run along the axis after that of the plane, rows along the one after that.
/// Columns, rows and the axis are right-handed.
struct PlaneVertex {
  std::uint32_t vertex;  ///< index into Solid::vertices
  std::uint32_t column, row;
  std::uint32_t mask;  ///< octant mask
};

/// Some planes normal to an axis, the work of one thread.
struct PlaneChunk {
  int axis;
  std::size_t begin, end;  ///< planes
};

/// The vertices of a solid, plane by plane along one axis.
struct PlaneOrder {
  Array<PlaneVertex> vertices;       ///< by plane, then row, then column
  std::vector<std::uint32_t> first;  ///< plane p holds vertices [first[p], first[p + 1])

  std::size_t planes() const { return first.size() - 1; }
  std::span<const PlaneVertex> plane(std::size_t p) const {
    return std::span(vertices).subspan(first[p], first[p + 1] - first[p]);
  }
  std::span<const PlaneVertex> vertices_of(const PlaneChunk& chunk) const {
    return std::span(vertices).subspan(first[chunk.begin], first[chunk.end] - first[chunk.begin]);
  }
};

/// The planes of all three axes. Rows are the lines on which edges lie, so the ends of an edge are neighbors
/// on a row.
using Planes = std::array<PlaneOrder, 3>;

/// Sorts the vertices into their planes, in parallel. Throws Error(resources) beyond 2^32 - 2 vertices.
Planes make_planes(const Solid& solid);

/// All planes, by axis, in chunks of some thousand vertices or one plane.
std::vector<PlaneChunk> cut_into_chunks(const Planes& planes);

/// The quadrants of a plane around a point, as bits of a quadrant mask.
enum Quadrant : std::uint8_t { left_below, right_below, left_above, right_above };

/// The octant behind a quadrant of the plane normal to `axis`, on the negative (0) or positive (1) side.
constexpr unsigned octant_at(int axis, unsigned side, Quadrant quadrant) {
  return side << axis | (quadrant & 1u) << (axis + 1) % 3 | quadrant >> 1u << (axis + 2) % 3;
}

/// The quadrants of a plane that faces fill around a vertex, by octant mask, axis, and direction (0: towards
/// the positive side of the axis, 1: negative).
inline constexpr auto kFaceQuadrants = [] {
  std::array<std::array<std::array<std::uint8_t, 2>, 3>, 256> quadrants{};
  for (unsigned mask = 0; mask < 256; ++mask)
    for (int axis = 0; axis < 3; ++axis) {
      const unsigned below = detail::side_quadrants(mask, axis, 0),
                     above = detail::side_quadrants(mask, axis, 1);
      quadrants[mask][axis] = {std::uint8_t(below & ~above), std::uint8_t(above & ~below)};
    }
  return quadrants;
}();

/// The number of these quadrants in both directions, by axis and octant mask. The angles of a triangle add up
/// to two quadrants, so faces have half as many triangles as they fill quadrants around their vertices.
inline constexpr auto kFilledQuadrants = [] {
  std::array<std::array<std::uint8_t, 256>, 3> filled{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t mask = 0; mask < 256; ++mask)
      for (const std::uint8_t quadrants : kFaceQuadrants[mask][axis])
        filled[axis][mask] = std::uint8_t(filled[axis][mask] + std::popcount(quadrants));
  return filled;
}();

/// The columns of a plane's vertices as small numbers, in the same order.
class PlaneColumns {
 public:
  void assign(std::span<const PlaneVertex> plane);

  /// The column of vertex i of the plane, less than count().
  std::uint32_t operator[](std::size_t i) const {
    return ranks_.empty() ? plane_[i].column - lowest_ : ranks_[i];
  }
  std::uint32_t count() const { return count_; }

 private:
  static constexpr std::uint32_t kFew = 1 << 16;  // so many entries fit the cache of a core

  std::span<const PlaneVertex> plane_;
  std::uint32_t lowest_ = 0, count_ = 0;
  Ranks ranks_;
};

/// The number of parts into which the search for edges is divided.
inline std::size_t edge_parts(const Planes& planes) {
  std::size_t vertices = 0;
  for (const PlaneOrder& order : planes) vertices = std::max(vertices, order.vertices.size());
  return 3 * std::clamp(vertices / 2048, std::size_t{1}, std::size_t{64});
}

/// Calls f(part, axis, lower, upper) for every edge, with the vertices at its lower and upper end. Runs in
/// parallel over edge_parts(planes) parts. The edges of a part come one after the other in a fixed order.
template <class F>
void for_each_edge(const Planes& planes, F&& f) {
  const std::size_t parts = edge_parts(planes), chunks = parts / 3;  // chunks of each axis
  parallel_for_each(0, parts, 1, [&](std::size_t part) {
    const int axis = int(part / chunks);
    const std::size_t chunk = part % chunks;
    const Array<PlaneVertex>& line = planes[(axis + 2) % 3].vertices;
    const std::size_t end = line.size() * (chunk + 1) / chunks;
    for (std::size_t i = line.size() * chunk / chunks; i < end; ++i)
      if (kOctants[line[i].mask].edges[2 * axis] != 0) f(part, axis, line[i], line[i + 1]);
  });
}

}  // namespace boxunion

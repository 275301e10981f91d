#pragma once

#include <cstddef>
#include <cstdint>

#include "core/boundary/faces.hpp"
#include "core/boundary/planes.hpp"
#include "core/boundary/points.hpp"

namespace boxunion {

/// The fan at the first point of a loop of a face. At the first point of an outer loop, the face fills only
/// the quadrant right above; at that of a hole, it fills all others (see find_faces).
inline std::uint32_t fan_of_loop(const Solid& solid, const Fans& fans, const Faces& faces,
                                 NonManifold contacts, std::size_t face, std::uint32_t loop) {
  const std::uint32_t point = faces.loop_points[faces.first_point[loop]];
  if (contacts == NonManifold::split) return point;
  const Quadrant quadrant = loop == faces.first_loop[face] ? right_above : left_above;
  const int axis = faces.direction[face] / 2;
  const PlaneVertex vertex{point, 0, 0, solid.vertices[point].mask};
  return fans.at(vertex, octant_at(axis, faces.direction[face] % 2, quadrant), axis);
}

/// Calls join(fan, fan) for fans of one shell, from several threads: across all edges, and from the outer
/// loop of every face to its holes. This connects all fans of a shell.
template <class Join>
void join_shells(const Solid& solid, const Planes& planes, const Fans& fans, const Faces& faces,
                 NonManifold contacts, Join&& join) {
  constexpr std::size_t kGrain = 1 << 11;  // faces
  for_each_edge(planes, [&](std::size_t, int axis, const PlaneVertex& lower, const PlaneVertex& upper) {
    const int sectors = kOctants[lower.mask].edges[2 * axis];
    for (int sector = 0; sector < sectors; ++sector)
      join(fans.at_edge(lower, 2 * axis, sector), fans.at_edge(upper, 2 * axis + 1, sector));
  });
  parallel_for_each(0, faces.size(), kGrain, [&](std::size_t face) {
    for (std::uint32_t hole = faces.first_loop[face] + 1; hole < faces.first_loop[face + 1]; ++hole)
      join(fan_of_loop(solid, fans, faces, contacts, face, faces.first_loop[face]),
           fan_of_loop(solid, fans, faces, contacts, face, hole));
  });
}

}  // namespace boxunion

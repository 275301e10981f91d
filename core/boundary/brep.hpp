#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/base/memory.hpp"
#include "core/boundary/planes.hpp"
#include "core/boundary/points.hpp"
#include "core/boundary/shells.hpp"
#include "core/solid/solid.hpp"

namespace boxunion {

/// The faces of a solid and their loops, in flat arrays with offsets.
///
/// A face is an edge-connected set of coplanar points of the boundary with one outward direction. Each of its
/// loops is a closed chain of edges, as the points on it in order: the outer one counter-clockwise seen from
/// outside, holes clockwise. A loop follows the quadrants that the face fills, so every point on a face's
/// boundary is on its loop, collinear or not, and at two diagonal quadrants it stays with its own, so it may
/// visit a point twice. Faces come by axis, plane and direction, and each has its outer loop first.
struct Faces {
  Array<std::uint32_t> loop_points;        ///< of one loop after the other
  Array<std::uint32_t> first_point = {0};  ///< loop l has loop_points [first_point[l], first_point[l + 1])
  Array<std::uint32_t> first_loop = {0};   ///< face f has loops [first_loop[f], first_loop[f + 1])
  Array<std::uint8_t> direction;           ///< of each face: 0 .. 5 for +x, -x, +y, -y, +z, -z

  std::size_t size() const { return direction.size(); }
  std::size_t loops() const { return first_point.size() - 1; }
  std::size_t holes() const { return loops() - size(); }
  std::size_t holes(std::size_t face) const { return first_loop[face + 1] - first_loop[face] - 1; }
  std::span<const std::uint32_t> loop(std::size_t l) const {
    return std::span(loop_points).subspan(first_point[l], first_point[l + 1] - first_point[l]);
  }
};

/// The ends of an edge, the lower one first.
using Edge = std::array<std::uint32_t, 2>;

/// The boundary representation of a solid (Vigo et al. 2012 in López Monterde et al., section 3; here with
/// holes, pseudo-manifolds and shells). Points are numbered as class Points says; all else refers to their
/// numbers.
struct Brep {
  NonManifold contacts = NonManifold::keep;
  Array<Point> points;
  Array<Edge> edges;  ///< maximal segments between neighboring points, by axis
  Faces faces;
  Shells shells;
};

/// The faces of a solid. Near-linear in its vertices, parallel over planes. Throws Error(resources) where an
/// offset would not fit 32 bits, or memory does not suffice.
Faces find_faces(const Planes& planes, const Points& points);

/// The edges of a solid; a non-manifold edge comes once if contacts are kept, for each filled sector if
/// split.
Array<Edge> find_edges(const Planes& planes, const Points& points);

/// All of it. Calls finish(stage) on this thread after each stage, for clocks, and to throw where the caller
/// wants to stop.
Brep make_brep(const Solid& solid, NonManifold contacts,
               const std::function<void(std::string_view)>& finish = {});

}  // namespace boxunion

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "boxunion/array.hpp"
#include "boxunion/export.hpp"
#include "boxunion/solid.hpp"

namespace boxunion {

/// What becomes of non-manifold edges (four faces) and vertices (several fans).
enum class NonManifold {
  keep,  ///< they stay, as true contacts
  split  ///< a copy of the vertex for each fan, of the edge for each filled sector, so that a manifold
         ///< results
};

/// A position: x, y, z in the boxes' unit.
using Point = std::array<double, 3>;

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

/// The shells of a boundary and what they enclose.
///
/// A shell joins faces across edges; at a non-manifold edge it joins those that bound the same filled sector.
/// So it belongs to one body, a component of the solid's interior (pieces that share a face). One shell of a
/// body encloses it; the others are its cavities. Shells are numbered by their lowest vertices, bodies by
/// their outer shells'.
struct Shells {
  Array<std::uint32_t> of_face;      ///< the shell of every face
  std::vector<std::uint32_t> body;   ///< of every shell
  std::vector<std::uint8_t> cavity;  ///< is the shell a cavity?
  std::size_t bodies = 0;

  std::size_t size() const { return body.size(); }
  std::size_t cavities() const { return size() - bodies; }
};

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

/// The boundary of a solid. Calls finish(stage) on this thread after each stage, for clocks, and to throw
/// where the caller wants to stop.
BOXUNION_API Brep make_brep(const Solid& solid, NonManifold contacts,
                            const std::function<void(std::string_view)>& finish = {});

}  // namespace boxunion

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

/// How non-manifold edges (four faces) and vertices (several fans) are treated.
enum class NonManifold {
  keep,  ///< kept as true contacts
  split  ///< copied, a vertex for each fan and an edge for each filled sector; gives a manifold
};

/// A position: x, y, z in the unit of the boxes.
using Point = std::array<double, 3>;

/// The faces of a solid and their loops, in flat arrays with offsets.
///
/// A face is an edge-connected set of coplanar points of the boundary with one outward direction. Each of its
/// loops is a closed chain of edges, given by its points in order. Seen from outside, the outer loop runs
/// counter-clockwise, holes clockwise. A loop follows the quadrants that the face fills. So it includes every
/// point on the boundary of the face, even collinear ones. At two diagonal quadrants it stays with its own
/// quadrant, so it may visit a point twice. Faces come by axis, plane and direction. The first loop of each
/// face is the outer one.
struct Faces {
  Array<std::uint32_t> loop_points;        ///< points of all loops, one loop after the other
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
/// A shell joins faces across edges. At a non-manifold edge it joins those that bound the same filled sector.
/// So a shell belongs to one body, a component of the interior of the solid (pieces that share a face). One
/// shell of a body encloses it; the others are its cavities. Shells are numbered by their lowest vertices,
/// bodies by the numbers of their outer shells.
struct Shells {
  Array<std::uint32_t> of_face;      ///< the shell of every face
  std::vector<std::uint32_t> body;   ///< of every shell
  std::vector<std::uint8_t> cavity;  ///< 1 if the shell is a cavity
  std::size_t bodies = 0;

  std::size_t size() const { return body.size(); }
  std::size_t cavities() const { return size() - bodies; }
};

/// The boundary representation of a solid (Vigo et al. 2012 in López Monterde et al., section 3; here with
/// holes, pseudo-manifolds and shells). Edges and faces refer to points by number.
struct Brep {
  NonManifold contacts = NonManifold::keep;
  Array<Point> points;
  Array<Edge> edges;  ///< maximal segments between neighboring points, by axis
  Faces faces;
  Shells shells;
};

/// The boundary of a solid. Calls finish(stage) on this thread after each stage, for clocks, or to stop by an
/// exception.
BOXUNION_API Brep make_brep(const Solid& solid, NonManifold contacts,
                            const std::function<void(std::string_view)>& finish = {});

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "boxunion/array.hpp"
#include "boxunion/brep.hpp"
#include "boxunion/export.hpp"

namespace boxunion {

/// Three points, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// The triangles of faces, face by face.
struct Triangulation {
  Array<Triangle> triangles;
  Array<std::uint32_t> first;  ///< face f has triangles [first[f], first[f + 1])
};

/// Cuts every face into triangles between its own points: n + 2 * holes - 2 for n points on its loops. Every
/// point is used, so neighboring faces fit without a T-junction, and no triangle has zero area. Exact. Takes
/// O(n log n) time for a face. Parallel over faces. Throws Error(resources) beyond 2^32 - 1 triangles.
BOXUNION_API Triangulation triangulate(std::span<const Point> points, const Faces& faces);

/// A closed, oriented triangle mesh.
struct Mesh {
  Array<Point> points;
  Array<Triangle> triangles;
};

/// The boundary of a solid as a mesh: the points of make_brep and the triangles of triangulate, in another
/// order. Faster, because it needs no faces.
BOXUNION_API Mesh make_mesh(const Solid& solid, NonManifold contacts);

}  // namespace boxunion

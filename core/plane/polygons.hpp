#pragma once

#include "core/boundary/brep.hpp"
#include "core/plane/contour.hpp"

namespace boxunion {

/// The polygons with holes that a contour bounds, as faces of a solid seen from above (direction +z). Each is
/// an edge-connected part of the union. Points are indices into Contour::vertices. Outer loops run
/// counter-clockwise, holes clockwise. No loop visits a vertex twice: corners of a polygon that touch bound a
/// hole, and holes that touch each other are two. So every polygon is valid in the sense of simple features
/// (ISO 19125, as GEOS and Boost.Geometry check it). Polygons come in the order of their lowest vertices, and
/// so do the holes of each. Throws Error(resources) beyond 2^31 - 1 vertices.
Faces find_polygons(const Contour& contour);

}  // namespace boxunion

#pragma once

#include "core/brep.hpp"
#include "core/contour.hpp"

namespace boxunion {

/// The polygons with holes that a contour bounds, as faces of a solid seen from above (direction +z): each is
/// an edge-connected part of the union. Points are indices into Contour::vertices; outer loops run
/// counter-clockwise, holes clockwise. Where corners touch, a loop stays with its quadrant, so it may visit a
/// vertex twice. Polygons come in the order of their lowest vertices, and so do the holes of each. Throws
/// Error(resources) beyond 2^31 - 1 vertices.
Faces find_polygons(const Contour& contour);

}  // namespace boxunion

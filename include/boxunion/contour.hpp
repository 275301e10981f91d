#pragma once

#include <array>
#include <cstdint>

#include "boxunion/array.hpp"
#include "boxunion/axis.hpp"
#include "boxunion/brep.hpp"
#include "boxunion/export.hpp"
#include "boxunion/rectangle.hpp"

namespace boxunion {

/// A vertex of the union of rectangles: its ordinals, and which of the four quadrants around it are filled
/// (bit 0: left below, 1: right below, 2: left above, 3: right above). The mask is constant along neither
/// axis. One or three quadrants are a corner; two diagonal ones are two corners that touch.
struct ContourVertex {
  std::uint32_t x, y;
  std::uint32_t quadrants;

  friend bool operator==(const ContourVertex&, const ContourVertex&) = default;
};

/// The union of rectangles in the plane, as its vertices. Regularised like a union of boxes.
struct Contour {
  PlaneAxes axes;
  Array<ContourVertex> vertices;  ///< sorted by y, then x; one at a point

  /// The position of a vertex: x and y in the unit of the rectangles, exact.
  std::array<double, 2> position(const ContourVertex& v) const {
    return {axes[0].coordinate(v.x), axes[1].coordinate(v.y)};
  }
};

/// Finds the union of rectangles, in parallel and exactly for any coordinates. The result does not depend on
/// their order or on threads. Throws Error(input) for an invalid rectangle, Error(resources) if memory does
/// not suffice.
BOXUNION_API Contour find_contour(const RectangleSet& rectangles);

/// Integral properties of a union in the plane: exact values, rounded once, like MassProperties.
struct ContourProperties {
  double area = 0;
  double perimeter = 0;  ///< the length of the contour; common edges of touching rectangles do not count
};
BOXUNION_API ContourProperties measure(const Contour& contour);

/// The polygons with holes that a contour bounds, as faces of a solid seen from above (direction +z). Each is
/// an edge-connected part of the union. Points are indices into Contour::vertices. Outer loops run
/// counter-clockwise, holes clockwise. No loop visits a vertex twice: corners of a polygon that touch bound a
/// hole, and holes that touch each other are two. So every polygon is valid in the sense of simple features
/// (ISO 19125, as GEOS and Boost.Geometry check it). Polygons come in the order of their lowest vertices, and
/// so do the holes of each. Throws Error(resources) beyond 2^31 - 1 vertices.
BOXUNION_API Faces find_polygons(const Contour& contour);

}  // namespace boxunion

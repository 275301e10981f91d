#pragma once

#include <array>
#include <cstdint>

#include "core/base/memory.hpp"
#include "core/boxes/axis.hpp"
#include "core/boxes/rectangle.hpp"
#include "core/plane/contour_cell.hpp"

namespace boxunion {

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
Contour find_contour(const RectangleSet& rectangles);

/// Integral properties of a union in the plane: exact values, rounded once, like MassProperties.
struct ContourProperties {
  double area = 0;
  double perimeter = 0;  ///< the length of the contour; common edges of touching rectangles do not count
};
ContourProperties measure(const Contour& contour);

}  // namespace boxunion

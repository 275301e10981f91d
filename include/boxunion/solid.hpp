#pragma once

#include <array>
#include <cstdint>

#include "boxunion/array.hpp"
#include "boxunion/axis.hpp"

namespace boxunion {

/// A vertex of the union: its ordinals on the three axes and its octant mask (see octants.hpp).
struct Vertex {
  std::uint32_t x, y, z;
  std::uint32_t mask;

  friend bool operator==(const Vertex&, const Vertex&) = default;
  /// Vertices sort by z, then y, then x. A solid has at most one vertex at a point, so the mask need not be
  /// compared.
  friend bool operator<(const Vertex& a, const Vertex& b) {
    if (a.z != b.z) return a.z < b.z;
    if (a.y != b.y) return a.y < b.y;
    return a.x < b.x;
  }
};

/// The union as its vertices. Everything else (boundary, EVM, decompositions) follows from them.
struct Solid {
  Axes axes;
  Array<Vertex> vertices;  ///< sorted by z, then y, then x; one at a point
};

/// A vertex with its coordinates.
struct PlacedVertex {
  std::array<double, 3> point;  ///< x, y, z
  std::uint8_t mask = 0;        ///< octant mask
};
/// A vertex of a solid with these axes.
inline PlacedVertex place(const Vertex& v, const Axes& axes) {
  return {{axes[0].coordinate(v.x), axes[1].coordinate(v.y), axes[2].coordinate(v.z)}, std::uint8_t(v.mask)};
}

}  // namespace boxunion

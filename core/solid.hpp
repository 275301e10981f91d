#pragma once

#include <array>
#include <cstdint>

#include "core/axis.hpp"
#include "core/memory.hpp"
#include "core/parallel.hpp"
#include "core/vertex.hpp"

namespace boxunion {

/// The union as its vertices: everything else (boundary, EVM, decompositions) follows from them.
struct Solid {
  Axes axes;
  Array<Vertex> vertices;  ///< sorted by z, then y, then x; one at a point
};

/// A vertex where its coordinates are.
struct PlacedVertex {
  std::array<double, 3> point;  ///< x, y, z
  std::uint8_t mask = 0;        ///< octant mask
};
/// A vertex of a solid with these axes.
inline PlacedVertex place(const Vertex& v, const Axes& axes) {
  return {{axes[0].coordinate(v.x), axes[1].coordinate(v.y), axes[2].coordinate(v.z)}, std::uint8_t(v.mask)};
}

/// Collects the vertices of a union and sorts them.
class SolidSink : public VertexSink {
 public:
  void add(std::span<const Vertex> vertices) override;
  /// The solid of everything added so far, sorted in parallel; leaves the sink empty. Holds 32 bytes a vertex
  /// at its peak, the result included. Not while another thread adds.
  Solid take(Axes axes);

 private:
  struct Part {
    Array<Vertex> vertices;
    std::array<std::uint32_t, 3> bits{};  // that occur in x, y and z
  };
  PerThread<Part> parts_;
};

}  // namespace boxunion

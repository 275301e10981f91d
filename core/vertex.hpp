#pragma once

#include <cstdint>
#include <span>

namespace boxunion {

/// A vertex of the union: ordinals on the three axes and the octant mask (see octants.hpp).
struct Vertex {
  std::uint32_t x = 0, y = 0, z = 0;
  std::uint32_t mask = 0;

  friend bool operator==(const Vertex&, const Vertex&) = default;
  /// Vertices sort by z, then y, then x; a solid has one vertex at a point, so the mask never decides.
  friend bool operator<(const Vertex& a, const Vertex& b) {
    if (a.z != b.z) return a.z < b.z;
    if (a.y != b.y) return a.y < b.y;
    return a.x < b.x;
  }
};

/// Takes the vertices of a union, batch by batch in any order, each vertex once.
class VertexSink {
 public:
  virtual ~VertexSink() = default;
  /// Takes one batch. Called from several threads at once.
  virtual void add(std::span<const Vertex> vertices) = 0;
};

}  // namespace boxunion

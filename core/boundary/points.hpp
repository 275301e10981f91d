#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/brep.hpp"
#include "core/base/memory.hpp"
#include "core/boundary/planes.hpp"
#include "core/solid/fans.hpp"
#include "core/solid/solid_sink.hpp"

namespace boxunion {

/// Numbers the fans of all vertices, vertex by vertex.
class Fans {
 public:
  /// Throws Error(resources) if there are more than 2^32 - 2 fans.
  explicit Fans(const Solid& solid);

  std::uint32_t count() const { return count_; }
  /// The fan of a facet (octant, axis) of a vertex; see MaskFans.
  std::uint32_t at(const PlaneVertex& v, unsigned octant, int axis) const {
    return first_[v.vertex] + kFans[v.mask].of[octant][axis];
  }
  /// The fan of the filled sector 0 or 1 of the edge that leaves a vertex in a direction (+x, -x, +y, ...).
  std::uint32_t at_edge(const PlaneVertex& v, int direction, int sector) const {
    return first_[v.vertex] + kFans[v.mask].at_edge[direction][sector];
  }
  /// The vertex of a fan, found by binary search.
  std::uint32_t vertex(std::uint32_t fan) const {
    return static_cast<std::uint32_t>(std::ranges::upper_bound(first_, fan) - first_.begin() - 1);
  }
  /// The vertex of every fan.
  Array<std::uint32_t> vertices() const;

 private:
  std::vector<std::uint32_t> first_;  // by vertex
  std::uint32_t count_ = 0;
};

/// True if both copies of a non-manifold edge along an axis would join the same two points, by the octant
/// masks at its lower and upper end.
inline bool needs_midpoint(unsigned lower, unsigned upper, int axis) {
  const auto &at_lower = kFans[lower].at_edge[2 * axis], &at_upper = kFans[upper].at_edge[2 * axis + 1];
  return at_lower[0] == at_lower[1] && at_upper[0] == at_upper[1];
}

/// The point between the ends of an edge along an axis, rounded. Throws Error(input) if no double lies
/// between them.
Point midpoint(const Point& lower, const Point& upper, int axis);

/// The points of a boundary: the vertices of a solid, or copies of them if non-manifold contacts are split.
///
/// If contacts are kept, point i is vertex i. If they are split, point i is fan i. If both copies of an edge
/// would join the same two points, a midpoint cuts one copy in two. Midpoints are the only new positions, and
/// come last.
class Points {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Keeps a reference to the solid. Throws Error(resources) if there are more than 2^32 - 2 points.
  Points(const Solid& solid, const Planes& planes, NonManifold contacts);

  NonManifold contacts() const { return contacts_; }
  std::size_t size() const;
  bool has_midpoints() const { return !midpoints_.empty(); }
  /// The point at a facet of a vertex; see MaskFans.
  std::uint32_t at(const PlaneVertex& v, unsigned octant, int axis) const {
    return contacts_ == NonManifold::keep ? v.vertex : fans_.at(v, octant, axis);
  }
  /// The point at a filled sector (0 or 1) of an edge that leaves a vertex in a direction (+x, -x, +y, ...).
  std::uint32_t at_edge(const PlaneVertex& v, int direction, int sector) const {
    return contacts_ == NonManifold::keep ? v.vertex : fans_.at_edge(v, direction, sector);
  }
  /// The midpoint of one sector's copy of the edge along an axis whose lower end is a vertex, or kNone.
  std::uint32_t between(std::uint32_t lower, int axis, int sector) const;
  /// An edge that has a midpoint. Midpoints are sorted by key(), and numbered in that order.
  struct Midpoint {
    std::uint32_t lower, upper;  // vertices
    int axis;
  };
  static std::uint64_t key(std::uint32_t lower, int axis) {
    return std::uint64_t{lower} << 2 | unsigned(axis);
  }
  std::span<const Midpoint> midpoints() const { return midpoints_; }
  /// The positions of the points. They are exact, except for midpoints, which are rounded. Throws
  /// Error(input) if no double lies between the ends of an edge with a midpoint.
  Array<Point> positions() const;

 private:
  const Solid* solid_;
  NonManifold contacts_;
  Fans fans_;
  std::vector<Midpoint> midpoints_;  // by key
};

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>

namespace boxunion {

/// Integral properties of a union. Every number is the exact value for the given coordinates, rounded once to
/// the nearest double (ties to even), so it does not depend on order, threads, method or device. A value
/// beyond the range of double is infinite.
struct MassProperties {
  std::uint64_t vertices = 0;
  std::uint64_t extreme_vertices = 0;             ///< vertices with an odd octant mask
  std::array<std::array<double, 3>, 2> bounds{};  ///< of the union; zeros if it is empty
  double volume = 0;
  double area = 0;
  double edge_length = 0;            ///< of the set of edge points: a non-manifold edge counts once
  std::array<double, 3> centroid{};  ///< zeros if the volume is zero
  std::array<std::array<double, 3>, 3> inertia{};  ///< about the centroid, unit density

  friend bool operator==(const MassProperties&, const MassProperties&) = default;
};

}  // namespace boxunion

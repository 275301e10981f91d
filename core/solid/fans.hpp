#pragma once

#include <array>
#include <cstdint>

#include "boxunion/octants.hpp"

namespace boxunion {

/// How the faces around a vertex are connected, for one octant mask.
///
/// A facet (octant, axis) is the quarter plane between a filled octant and its empty neighbor along the axis.
/// Its face looks away from the filled octant. Two facets that meet at an edge belong together if the same
/// filled sector lies between them. A non-manifold edge has two filled sectors, and so two such pairs. Facets
/// that belong together form a ring, a *fan*. A vertex of a manifold has one fan, a non-manifold vertex up to
/// four.
struct MaskFans {
  static constexpr std::uint8_t kNone = 0xff;

  std::uint8_t count = 0;
  /// The fan of a facet, by octant and axis; kNone if there is no such facet.
  std::array<std::array<std::uint8_t, 3>, 8> of{};
  /// The fans of the filled sectors at the edges that leave the vertex towards +x, -x, +y, -y, +z, -z. kNone
  /// if there is no edge, and for the second sector of a manifold edge. The two sectors of a non-manifold
  /// edge along an axis come in the order of their sides on the next axis, so the same one comes first at
  /// both ends.
  std::array<std::array<std::uint8_t, 2>, 6> at_edge{};
};

namespace detail {

constexpr bool is_facet(unsigned mask, unsigned octant, unsigned axis) {
  return (mask >> octant & 1u) && !(mask >> (octant ^ 1u << axis) & 1u);
}

/// The facet, as 3 * octant + axis, that meets (octant, axis) at the edge along `edge_axis` around filled
/// octants.
constexpr unsigned facet_beyond(unsigned mask, unsigned octant, unsigned axis, unsigned edge_axis) {
  const unsigned other = 3 - axis - edge_axis;
  const unsigned beside = octant ^ 1u << other, across = beside ^ 1u << axis;
  if (!(mask >> beside & 1u)) return 3 * octant + other;
  if (!(mask >> across & 1u)) return 3 * beside + axis;
  return 3 * across + other;
}

constexpr MaskFans mask_fans(unsigned mask) {
  MaskFans fans;
  for (auto& octant : fans.of) octant = {MaskFans::kNone, MaskFans::kNone, MaskFans::kNone};
  for (unsigned start = 0; start < 24; ++start) {
    if (!is_facet(mask, start / 3, start % 3) || fans.of[start / 3][start % 3] != MaskFans::kNone) continue;
    // A facet has two edges. Cross one of them, then the other one of the next facet, until the ring is
    // closed.
    unsigned facet = start, edge_axis = (start + 1) % 3;
    do {
      fans.of[facet / 3][facet % 3] = fans.count;
      facet = facet_beyond(mask, facet / 3, facet % 3, edge_axis);
      edge_axis = 3 - facet % 3 - edge_axis;
    } while (facet != start);
    ++fans.count;
  }
  for (unsigned direction = 0; direction < 6; ++direction) {
    const unsigned edge_axis = direction / 2, u = (edge_axis + 1) % 3, v = (edge_axis + 2) % 3;
    auto& sectors = fans.at_edge[direction];
    sectors = {MaskFans::kNone, MaskFans::kNone};
    const int edge = kOctants[mask].edges[direction];
    for (unsigned k = 0; k < 4 && edge != 0; ++k) {
      const unsigned octant = (direction & 1u ? 0u : 1u) << edge_axis | (k & 1u) << u | k >> 1 << v;
      const unsigned axis = is_facet(mask, octant, u) ? u : v;
      if (is_facet(mask, octant, axis)) sectors[edge == 2 ? k & 1u : 0] = fans.of[octant][axis];
    }
  }
  return fans;
}

constexpr std::array<MaskFans, 256> make_fan_table() {
  std::array<MaskFans, 256> table{};
  for (unsigned mask = 0; mask < 256; ++mask) table[mask] = mask_fans(mask);
  return table;
}

}  // namespace detail

/// The fans of every octant mask.
inline constexpr std::array<MaskFans, 256> kFans = detail::make_fan_table();

}  // namespace boxunion

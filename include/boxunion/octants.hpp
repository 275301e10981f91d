#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace boxunion {

/// Everything that the octant mask of a point decides.
///
/// Bit k of the mask says whether octant k = x + 2y + 4z (x, y, z in {0, 1}; 1 is the positive side) of the
/// point's neighborhood lies in the union. The integral properties of the union are sums over its vertices
/// (Franklin, UNION3, section 4; generalised here to every mask):
///   volume      = sum of volume * x*y*z
///   area        = sum of area[0] * y*z + area[1] * x*z + area[2] * x*y   (area[a]: faces normal to axis a)
///   edge length = sum of length[0] * x + length[1] * y + length[2] * z   (length[a]: edges along axis a)
/// A non-manifold edge (four faces) counts once in the edge length.
struct OctantProperties {
  bool vertex = false;   ///< the mask is not constant along any of the three axes
  bool extreme = false;  ///< odd number of filled octants (extreme vertex of the EVM)
  std::int8_t volume = 0;
  std::array<std::int8_t, 3> area{};
  std::array<std::int8_t, 3> length{};
  /// Faces that meet here, by outward direction +x, -x, +y, -y, +z, -z (López Monterde et al., section 4).
  std::array<std::uint8_t, 6> degrees{};
  /// Edges that leave the point towards +x, -x, +y, -y, +z, -z: 0 none, 1 edge, 2 non-manifold edge.
  std::array<std::uint8_t, 6> edges{};
};

namespace detail {

/// The four octants on one side of the point: bit u + 2v is the octant at (u, v) on the axes after `axis`.
constexpr unsigned side_quadrants(unsigned mask, unsigned axis, unsigned side) {
  const unsigned u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
  unsigned quadrants = 0;
  for (unsigned v = 0; v < 2; ++v)
    for (unsigned u = 0; u < 2; ++u) {
      const unsigned octant = side << axis | u << u_axis | v << v_axis;
      quadrants |= (mask >> octant & 1u) << (u + 2 * v);
    }
  return quadrants;
}

/// True if a quadrant mask is constant along its first (u) or second (v) axis.
constexpr bool constant_along_u(unsigned q) {
  return (q & 5u) == (q >> 1 & 5u);
}
constexpr bool constant_along_v(unsigned q) {
  return (q & 3u) == (q >> 2 & 3u);
}
constexpr bool is_corner(unsigned q) {
  return !constant_along_u(q) && !constant_along_v(q);
}
constexpr bool is_diagonal(unsigned q) {
  return q == 6u || q == 9u;
}

/// The number of faces at a vertex in each direction, by the quadrants exposed in it. One or three quadrants
/// are one face with a corner there; two diagonal ones are two faces. Two adjacent ones are a face that
/// passes straight through and does not count. The exception is the class of 00011011 (configuration (h) of
/// López Monterde et al.), whose two straight faces count twice each.
constexpr std::array<std::uint8_t, 6> face_degrees(unsigned mask) {
  std::array<std::uint8_t, 6> degrees{}, straight{};
  int total = 0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned below = side_quadrants(mask, axis, 0), above = side_quadrants(mask, axis, 1);
    const unsigned exposed[2] = {below & ~above, above & ~below};  // in positive, negative direction
    for (unsigned side = 0; side < 2; ++side) {
      const int quadrants = std::popcount(exposed[side]);
      const bool adjacent = quadrants == 2 && !is_diagonal(exposed[side]);
      const int degree = adjacent ? 0 : quadrants == 2 ? 2 : quadrants & 1;
      degrees[2 * axis + side] = std::uint8_t(degree);
      straight[2 * axis + side] = adjacent ? 2 : 0;
      total += degree;
    }
  }
  if (total == 2)  // only the class of 00011011
    for (unsigned direction = 0; direction < 6; ++direction) degrees[direction] |= straight[direction];
  return degrees;
}

constexpr OctantProperties octant_properties(unsigned mask) {
  OctantProperties p;
  p.vertex = true;
  for (unsigned axis = 0; axis < 3; ++axis)
    p.vertex &= side_quadrants(mask, axis, 0) != side_quadrants(mask, axis, 1);
  p.extreme = std::popcount(mask) & 1;
  for (unsigned octant = 0; octant < 8; ++octant)
    if (mask >> octant & 1u) p.volume = std::int8_t(p.volume + (std::popcount(octant) & 1 ? -1 : 1));

  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned below = side_quadrants(mask, axis, 0), above = side_quadrants(mask, axis, 1);
    for (unsigned quadrant = 0; quadrant < 4; ++quadrant)
      if ((below ^ above) >> quadrant & 1u)
        p.area[axis] = std::int8_t(p.area[axis] + (std::popcount(quadrant) & 1 ? -1 : 1));
    p.length[axis] = std::int8_t(int(is_corner(below)) - int(is_corner(above)));

    p.edges[2 * axis] = std::uint8_t(is_corner(above) + is_diagonal(above));
    p.edges[2 * axis + 1] = std::uint8_t(is_corner(below) + is_diagonal(below));
  }
  if (p.vertex) p.degrees = face_degrees(mask);
  return p;
}

constexpr std::array<OctantProperties, 256> make_octant_table() {
  std::array<OctantProperties, 256> table{};
  for (unsigned mask = 0; mask < 256; ++mask) table[mask] = octant_properties(mask);
  return table;
}

}  // namespace detail

/// The properties of every octant mask.
inline constexpr std::array<OctantProperties, 256> kOctants = detail::make_octant_table();

}  // namespace boxunion

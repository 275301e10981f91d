#pragma once

#include <cstdint>

#include "core/cells/packed.hpp"
#include "core/solid/mass.hpp"

// What a device would sum over cells, without one: boxes in packed coordinates of a tile. The sums count from
// 0 where packed coordinates count from 1, as the kernels' do.

namespace boxunion {

/// Does the tile own all of the box's boundary?
inline bool is_inside(const PackedBox& box, const PackedRegion& tile) {
  return packed::all_le(tile.lo, box.lo) && packed::all_le(box.hi, tile.hi - packed::pack(1, 1, 1));
}

/// Adds a part of the inside of the union.
void add_inside(LatticeSums& sums, const PackedRegion& region);

/// Adds a box that touches no other one of the tile.
void add_lone(LatticeSums& sums, const PackedBox& box, const PackedRegion& tile);

/// Adds the union of two boxes that touch each other and no other one, both inside the tile.
///
/// Volume, moments and area of a union are those of its parts less those of what the parts share. Edges and
/// vertices are not; how many there are is a matter of how the two boxes lie to each other on each axis,
/// which a table knows.
void add_pair(LatticeSums& sums, const PackedBox& a, const PackedBox& b);

}  // namespace boxunion

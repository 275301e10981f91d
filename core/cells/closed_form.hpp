#pragma once

#include <cstdint>

#include "core/cells/packed.hpp"
#include "core/solid/mass_sink.hpp"

// Sums in closed form, which need no device: boxes in packed coordinates of a tile. Like those of the
// kernels, the sums count from 0 where packed coordinates count from 1.

namespace boxunion {

/// True if the tile owns the whole boundary of a box.
inline bool is_inside(const PackedBox& box, const PackedRegion& tile) {
  return packed::all_le(tile.lo, box.lo) && packed::all_le(box.hi, tile.hi - packed::pack(1, 1, 1));
}

/// Adds a region inside the union.
void add_inside(LatticeSums& sums, const PackedRegion& region);

/// Adds a box that touches no other box of the tile.
void add_lone(LatticeSums& sums, const PackedBox& box, const PackedRegion& tile);

/// Adds the union of two boxes that touch each other and no other box, both inside the tile.
///
/// Volume, moments and area of a union are those of its parts less those of their intersection. For edges and
/// vertices this is not so. Their number depends only on the relation of the two boxes on each axis, and a
/// table holds it.
void add_pair(LatticeSums& sums, const PackedBox& a, const PackedBox& b);

}  // namespace boxunion

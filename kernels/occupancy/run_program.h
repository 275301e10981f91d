// Stage: runs the cell's program band by band, on a stack of bands.
// Reads: program's steps, interval, kept_count, rows_below. Writes: level, word; with REACH, filled and
// reach.

for (u32 b = 0u; b < bands; ++b) {
  u32 depth = 0u;
  for (u32 s = first_step; s < end_step; ++s) {
    const u32 operation = step[STEP_WORDS * s];
    if (operation <= STEP_CARVE) {
#include "occupancy/add_operand.h"
    } else if (operation == STEP_COMPLEMENT) {
      const u64 all = U64(nx) | (U64(ny) << PACKED_STRIDE);
      BAND_OF(of_cell, b, U64(0u), all)
      LANES(z, nz + 1u) level[32u * (depth - 1u) + z] ^= of_cell;
      SYNC;
    } else {
#include "occupancy/combine_results.h"
    }
  }
  LANES(z, nz + 1u) {
    const u64 bits = level[z];
    word[b * slices + z] = bits;
#ifdef REACH
#include "occupancy/note_filled.h"
#endif
  }
  SYNC;
}
#ifdef REACH
#include "occupancy/extend_reach.h"
#endif

// Adds a range of the cell's boxes to the last result of a program, or takes them out of it.
// Reads: operation, s, b, depth, interval. Writes: level, depth.

if (operation == STEP_PUSH) {
  LANES(z, nz + 1u) level[32u * depth + z] = U64(0u);
  ++depth;
  SYNC;
}
const u32 top = 32u * (depth - 1u);
const u32 begin = step[STEP_WORDS * s + 1u];
const u32 operands = step[STEP_WORDS * s + 2u];
for (u32 chunk = 0u; chunk < operands; chunk += STAGED) {
  const u32 staged = min(operands - chunk, STAGED);
  if (crowded) {
    const u32 from_item = begin + chunk;
#include "occupancy/retake_boxes.h"
  }
  const u32 first_box = crowded ? 0u : begin;
  for (u32 i = first_box; i < first_box + staged; ++i) {
    const u64 from = interval[i];
    const u64 to = interval[kept_count[0] + i];
    BAND_OF(of_box, b, from, to)
    const u32 z_from = FIELD(from, 2u);
    const u32 filled_slices = FIELD(to, 2u) + 1u - z_from;
    if (operation == STEP_CARVE) {
      LANES(z, filled_slices) level[top + z_from + z] &= ~of_box;
    } else {
      LANES(z, filled_slices) level[top + z_from + z] |= of_box;
    }
    SYNC;
  }
}

// Stage: fills the bitmap with the union of the cell's boxes.
// Reads: interval, kept_count, rows_below. Writes: word.

for (u32 chunk = 0u; chunk < count; chunk += STAGED) {
  if (crowded) {
    const u32 staged = min(count - chunk, STAGED);
    const u32 from_item = chunk;
#include "occupancy/retake_boxes.h"
  }
  for (u32 i = 0u; i < kept_count[0]; ++i) {
    const u64 from = interval[i];
    const u64 to = interval[kept_count[0] + i];
    const u32 z_from = FIELD(from, 2u);
    const u32 filled_slices = FIELD(to, 2u) + 1u - z_from;
    for (u32 b = 0u; b < bands; ++b) {
      BAND_OF(of_box, b, from, to)
      LANES(z, filled_slices) word[b * slices + z_from + z] |= of_box;
    }
    SYNC;
  }
}

// Stage for crowded cells: takes `staged` boxes of the cell again, from `from_item` on, and ranks them.
// Reads: from_item, staged. Writes: lo, hi, kept, kept_count, interval.

LANES(i, staged) {
  const u32 at = 2u * item[first + from_item + i];
  lo[i] = clip(box[at], origin, last);
  hi[i] = clip(box[at + 1u], origin, last);
  kept[i] = i;
}
ONE_LANE kept_count[0] = staged;
SYNC;
#include "occupancy/rank_boxes.h"

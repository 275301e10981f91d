// Stage: divides the boxes taken. Lone ones are added to the result at once, hidden ones are dropped, and the
// others are kept. In a crowded cell and in a cell with a program, all boxes are kept.
// Reads: lo, hi, staged, padded. Writes: kept, kept_count, and the result.

if (crowded || !united) { // all are kept
  LANES(i, staged) kept[i] = i;
  ONE_LANE kept_count[0] = staged;
} else {
  LANES(i, staged) {
    const u64 box_lo = lo[i];
    const u64 box_hi = hi[i];
    u64 touching = U64(0u); // numbers of boxes that touch it, contain it, and equal it, including itself
    u64 holding = U64(0u);
    u64 equal = U64(0u);
    for (u32 j = 0u; j < padded; ++j) {
      const u64 lo_j = lo[j];
      const u64 hi_j = hi[j];
      touching += ((hi_j - box_lo) & (box_hi - lo_j) & GUARDS) == GUARDS ? U64(1u) : U64(0u);
      const u64 below = (box_lo | GUARDS) - lo_j;
      const u64 above = hi_j - (box_hi ^ GUARDS);
      holding += (below & above & GUARDS) == GUARDS ? U64(1u) : U64(0u);
      equal += (below | above) == GUARDS ? U64(1u) : U64(0u);
    }
    bool hidden = holding > equal;
    if (equal > U64(1u)) { // the first of equal boxes hides the others
      for (u32 j = 0u; j < i; ++j) hidden = hidden || (lo[j] == box_lo && hi[j] == box_hi);
    }
    const u32 dropped = hidden ? 1u : 0u;
    if (touching == U64(1u)) {
#ifdef SUMS
#include "occupancy/add_lone_sums.h"
#else
#include "occupancy/add_lone_vertices.h"
#endif
    } else { // dropped boxes go to STAGED + i; branch-free, because the branch would be unpredictable
      LOCAL_FETCH_ADD(slot, kept_count[0], 1u - dropped);
      kept[slot ^ ((slot ^ (STAGED + i)) & (0u - dropped))] = i;
    }
  }
}
SYNC;

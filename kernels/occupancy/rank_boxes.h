// Stage: finds the intervals of the kept boxes between the points: the number of points below an upper end,
// and at or below a lower end.
// Reads: lo, hi, kept, kept_count, points, bound; in narrow cells present, below. Writes: interval.

LANES(i, 2u * kept_count[0]) {
  const u32 own = i < kept_count[0] ? 1u : 0u;
  const u32 k = kept[own != 0u ? i : i - kept_count[0]];
  const u64 end = own != 0u ? lo[k] : hi[k];
  u64 ranks = U64(0u);
  for (u32 a = 0u; a < 3u; ++a) {
    const u32 v = FIELD(end, a) + own;
    u32 rank = 0u;
    if (narrow) {
      const u32 w = 32u * a + (v >> 5);
      rank = below[w] + POPCOUNT(present[w] & ((1u << (v & 31u)) - 1u));
    } else {
      for (u32 b = 0u; b < points[a]; ++b) rank += bound[32u * a + b] < v ? 1u : 0u;
    }
    ranks |= U64(rank) << (PACKED_STRIDE * a);
  }
  interval[i] = ranks;
}
SYNC;

// Stage for narrow cells: lists the coordinates that mark_points.h has marked in all chunks.
// Reads: present. Writes: below, bound, points.

LANES(a, 3u) {
  u32 n = 0u;
  for (u32 w = 0u; w <= FIELD(last, a) >> 5; ++w) {
    below[32u * a + w] = n;
    u32 bits = present[32u * a + w];
    while (bits != 0u) {
      bound[32u * a + n] = 32u * w + LOWEST_BIT(bits);
      ++n;
      bits &= bits - 1u;
    }
  }
  points[a] = n;
}
SYNC;

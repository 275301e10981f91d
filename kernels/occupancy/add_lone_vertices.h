// Writes the corners of a lone box that the cell owns.
// Reads: box_lo, box_hi. Writes: vertex, total.

// corner k is the high end on axis a if bit a is set; its only filled octant is on the other side
u32 owned = 255u;
for (u32 a = 0u; a < 3u; ++a) {
  const u32 low_ends = a == 0u ? 0x55u : a == 1u ? 0x33u : 0x0fu;
  if (FIELD(box_lo, a) == 0u) owned &= ~low_ends;
  if (FIELD(box_hi, a) == FIELD(last, a)) owned &= low_ends;
}
if (owned != 0u) {
  RESERVE(POPCOUNT(owned))
  while (owned != 0u) {
    const u32 k = LOWEST_BIT(owned);
    owned &= owned - 1u;
    WRITE_VERTEX((k & 1u) != 0u ? FIELD(box_hi, 0u) : FIELD(box_lo, 0u),
                 (k & 2u) != 0u ? FIELD(box_hi, 1u) : FIELD(box_lo, 1u),
                 (k & 4u) != 0u ? FIELD(box_hi, 2u) : FIELD(box_lo, 2u), 1u << (7u - k))
  }
}

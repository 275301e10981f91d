// Stage for at most FEW boxes: finds their points and intervals by comparing all ends with all.
// Reads: lo, hi, kept, kept_count. Writes: points, bound, interval.

const u32 ends = (2u * kept_count[0] + 3u) & ~3u;
LANES(i, kept_count[0]) {
  end_of[i] = lo[kept[i]];
  end_of[kept_count[0] + i] = hi[kept[i]] ^ GUARDS;
}
LANES(i, 3u) end_of[2u * kept_count[0] + i] = U64(0u);
SYNC;
LANES(i, ends) {
  const u64 v = end_of[i];
  own_of[i] = (((v | GUARDS) - ONES) & ((last | GUARDS) - ONES - v) & GUARDS) >> PACKED_BITS;
}
SYNC;
LANES(i, 2u * kept_count[0]) {
  const u64 v = end_of[i];
  const u64 before = (v | GUARDS) - ONES;
  u64 rank = U64(0u);
  for (u32 j = 0u; j < ends; ++j) rank += ((before - end_of[j]) >> PACKED_BITS) & own_of[j];
  const u64 own = own_of[i];
  interval[i] = rank;
  // coordinates that the cell does not own go behind all others, to 96 + i
  const u64 behind = ONES * U64(96u + i) - ((U64(32u) << PACKED_STRIDE) | (U64(64u) << (2u * PACKED_STRIDE)));
  const u64 place = behind ^ ((behind ^ rank) & ((own << PACKED_BITS) - own));
  for (u32 a = 0u; a < 3u; ++a) bound[32u * a + FIELD(place, a)] = FIELD(v, a);
}
SYNC;
LANES(i, kept_count[0]) interval[i] += own_of[i];
ONE_LANE {
  u64 n = U64(0u);
  for (u32 j = 0u; j < ends; ++j) n += own_of[j];
  for (u32 a = 0u; a < 3u; ++a) points[a] = FIELD(n, a);
}

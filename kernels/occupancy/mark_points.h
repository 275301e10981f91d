// Stage for narrow cells: marks the coordinates of the kept boxes, chunk by chunk.
// Reads: lo, hi, kept, kept_count. Writes: present.

if (chunk == 0u) {
  LANES(i, 96u) present[i] = 0u;
  SYNC;
}
LANES(i, 2u * kept_count[0]) {
  const u64 v3 = (i & 1u) == 0u ? lo[kept[i >> 1]] : hi[kept[i >> 1]];
  for (u32 a = 0u; a < 3u; ++a) {
    const u32 v = FIELD(v3, a);
    if (v != 0u && v != FIELD(last, a)) { // the cell owns it
      LOCAL_OR(present[32u * a + (v >> 5)], 1u << (v & 31u));
    }
  }
}

// Stage for wide cells: inserts the coordinates of the kept boxes into the sorted points, chunk by chunk.
// Reads: lo, hi, kept, kept_count. Writes: bound, points.

LANES(a, 3u) { // insertion
  u32 n = points[a];
  for (u32 i = 0u; i < 2u * kept_count[0]; ++i) {
    const u32 k = kept[i >> 1];
    const u32 v = (i & 1u) == 0u ? FIELD(lo[k], a) : FIELD(hi[k], a);
    if (v == 0u || v == FIELD(last, a)) continue;
    u32 at = n;
    while (at > 0u && bound[32u * a + at - 1u] > v) --at;
    if (at > 0u && bound[32u * a + at - 1u] == v) continue;
    for (u32 j = n; j > at; --j) bound[32u * a + j] = bound[32u * a + j - 1u];
    bound[32u * a + at] = v;
    ++n;
  }
  points[a] = n;
}

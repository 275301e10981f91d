// Extends the reach of the cells with programs. Interval r lies between points r - 1 and r, or the ends of
// the cell.
// Reads: filled, bound. Writes: reach.

ONE_LANE {
  if (filled[0] != 0u) {
    for (u32 a = 0u; a < 3u; ++a) {
      const u32 n = a == 0u ? nx : a == 1u ? ny : nz;
      const u32 l = LOWEST_BIT(filled[a]);
      const u32 h = HIGHEST_BIT(filled[a]);
      const u32 low = FIELD(origin, a) + (l == 0u ? 1u : bound[32u * a + l - 1u]);
      const u32 high = FIELD(origin, a) + (h == n ? FIELD(last, a) : bound[32u * a + h]);
      reach[a] = min(reach[a], low);
      reach[a + 3u] = max(reach[a + 3u], high);
    }
  }
}

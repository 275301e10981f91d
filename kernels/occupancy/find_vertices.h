// Stage: finds the vertices, one band at a time. They are the points across which the octants change along
// every axis.
// Reads: word, bound, rows_below. Writes: the result.

for (u32 b = 0u; b < bands; ++b) {
  const u64 owned = ((U64(1u) << points_x) - U64(1u)) * rows_below[min(points_y - b * step_rows, step_rows)];
  LANES(k, points_z) {
    const u64 w0 = word[b * slices + k];
    const u64 w1 = word[b * slices + k + 1u];
    if ((w0 | w1) == U64(0u)) continue;
    const u64 across_x = (w0 ^ (w0 >> 1)) | (w1 ^ (w1 >> 1));
    const u64 across_y = (w0 ^ (w0 >> pitch)) | (w1 ^ (w1 >> pitch));
    const u64 rows_z = (w0 ^ w1) | ((w0 ^ w1) >> 1);
    const u64 across_z = rows_z | (rows_z >> pitch);
    u64 found = (across_x | (across_x >> pitch)) & (across_y | (across_y >> 1)) & across_z & owned;
    if (found == U64(0u)) continue;
    RESERVE(POPCOUNT64(found))
    while (found != U64(0u)) {
      const u32 at = LOWEST_BIT64(found);
      found &= found - U64(1u);
      const u32 row = (at * reciprocal) >> 12;
      const u32 bit = at - row * pitch;
      const u32 j = b * step_rows + row;
      const u64 octants_0 = w0 >> at;
      const u64 octants_1 = w1 >> at;
      const u32 mask = (U32(octants_0) & 3u) | ((U32(octants_0 >> pitch) & 3u) << 2) |
                       ((U32(octants_1) & 3u) << 4) | ((U32(octants_1 >> pitch) & 3u) << 6);
#ifdef SUMS
#include "occupancy/add_vertex_sums.h"
#else
      WRITE_VERTEX(bound[bit], bound[32u + j], bound[64u + k], mask)
#endif
    }
  }
}

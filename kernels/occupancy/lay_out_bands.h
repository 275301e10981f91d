// Stage: chooses how the rows of the bitmap share words, and clears the words.
// Reads: points_x, points_y, points_z. Defines: pitch, reciprocal, rows, step_rows, bands, slices. Writes:
// rows_below, word.

const u32 pitch = points_x + 1u;
const u32 reciprocal = 4096u / pitch + 1u; // (i * reciprocal) >> 12 is i / pitch for i up to 64
const u32 rows = max(min((64u * reciprocal) >> 12, points_y + 1u), 2u);
const u32 step_rows = rows - 1u;
const u32 bands = points_y <= step_rows ? 1u : (points_y + step_rows - 1u) / step_rows;
ONE_LANE {
  u64 below_row = U64(0u);
  for (u32 r = 0u; r <= rows; ++r) {
    rows_below[r] = below_row;
    below_row = (below_row << pitch) | U64(1u);
  }
}
const u32 slices = points_z + 1u;
LANES(i, bands * slices) word[i] = U64(0u);
SYNC;

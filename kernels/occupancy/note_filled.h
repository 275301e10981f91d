// Marks the intervals of each axis that a band fills.
// Reads: bits, b, z. Writes: filled.

if (bits != U64(0u)) {
  LOCAL_OR(filled[2], 1u << z);
  for (u32 r = 0u; r < rows; ++r) {
    const u32 of_row = U32((bits >> (r * pitch)) & ((U64(1u) << pitch) - U64(1u)));
    if (of_row == 0u) continue;
    LOCAL_OR(filled[0], of_row);
    LOCAL_OR(filled[1], 1u << min(b * step_rows + r, ny));
  }
}

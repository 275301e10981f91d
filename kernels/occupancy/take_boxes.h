// Stage: takes up to STAGED boxes of the cell, from `chunk` on, and clips them to it. After them come boxes
// that touch nothing, up to a multiple of four.
// Reads: chunk, staged, padded. Writes: lo, hi (with guard bits).

LANES(i, padded) {
  const u32 at = 2u * item[first + chunk + min(i, staged - 1u)];
  const bool real = i < staged; // padding touches nothing
  lo[i] = real ? clip(box[at], origin, last) : ~GUARDS;
  hi[i] = real ? clip(box[at + 1u], origin, last) | GUARDS : GUARDS;
}
SYNC;

// Shared by the kernels of cells. Boxes and cells are packed: three coordinates of 20 bits, each below a
// guard bit, in 64 bits, so that one subtraction compares all three axes.
#ifndef BOXUNION_CELL_H
#define BOXUNION_CELL_H

#define GUARDS ((U64(PACKED_GUARDS_HIGH) << 32) | U64(PACKED_GUARDS_LOW))
#define FIELD(packed, axis) (U32((packed) >> (PACKED_STRIDE * (axis))) & PACKED_MOST)

PARAMETERS_BEGIN
  CELL_PARAMETERS
PARAMETERS_END

// max(v - origin, 0) for each coordinate, and at most `last`
FN u64 clip(const u64 v, const u64 origin, const u64 last) {
  const u64 d = (v | GUARDS) - origin;
  const u64 above = d & GUARDS;
  const u64 kept = d & (above - (above >> PACKED_BITS));
  const u64 within = ((last | GUARDS) - kept) & GUARDS;
  const u64 mask = within - (within >> PACKED_BITS);
  return (kept & mask) | (last & ~mask);
}

#endif // BOXUNION_CELL_H

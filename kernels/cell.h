// What the kernels of cells share. Boxes and cells come packed: three coordinates of 20 bits, each below a guard bit,
// in 64 bits, so that one subtraction compares all three axes.
#ifndef BOXUNION_CELL_H
#define BOXUNION_CELL_H

#define GUARDS ((U64(0x40000200u) << 32) | U64(0x00100000u)) // bits 20, 41, 62
#define FIELD(packed, axis) (U32((packed) >> (21u * (axis))) & 0xfffffu)

PARAMETERS_BEGIN
  u32 first_run;
  u32 end_run;
  u32 capacity; // vertices that fit the output
  u32 two;      // 2
PARAMETERS_END

// max(v - origin, 0) of each coordinate, then at most `last`
FN u64 clip(const u64 v, const u64 origin, const u64 last) {
  const u64 d = (v | GUARDS) - origin;
  const u64 above = d & GUARDS;
  const u64 kept = d & (above - (above >> 20));
  const u64 within = ((last | GUARDS) - kept) & GUARDS;
  const u64 mask = within - (within >> 20);
  return (kept & mask) | (last & ~mask);
}

#endif // BOXUNION_CELL_H

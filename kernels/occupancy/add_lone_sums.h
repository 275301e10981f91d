// Adds a lone box to the sums in closed form.
// Reads: box_lo, box_hi, open. Writes: the sums.

// The part of a lone box on one axis: its ends that the cell owns, and the differences of the first three
// powers of its ends in the tile, as far as they belong to the sums of the cell.
#define LONE_AXIS(name, axis)                                                                          \
  const u32 name##_lo = FIELD(box_lo, axis);                                                           \
  const u32 name##_hi = FIELD(box_hi, axis);                                                           \
  const bool name##_begins = name##_lo > 0u;                                                           \
  const bool name##_ends = name##_hi < FIELD(last, axis);                                              \
  const u64 name##0 = U64((name##_begins ? 1u : 0u) + (name##_ends ? 1u : 0u));                        \
  const u64 name##_a = name##_begins ? U64(name##_lo - 1u + FIELD(origin, axis)) : U64(0u);            \
  const u64 name##_b = name##_ends || ((open >> (PACKED_STRIDE * (axis))) & U64(PACKED_MOST + 1u)) != U64(0u) \
                           ? U64(name##_hi - 1u + FIELD(origin, axis)) : U64(0u);                      \
  const u64 name##1 = name##_b - name##_a;                                                             \
  const u64 name##2 = name##_b * name##_b - name##_a * name##_a;                                       \
  const u64 name##3 = name##_b * name##_b * name##_b - name##_a * name##_a * name##_a;

LONE_AXIS(x, 0u)
LONE_AXIS(y, 1u)
LONE_AXIS(z, 2u)
vertices += x0 * y0 * z0;
extreme += x0 * y0 * z0;
const u64 yz = y1 * z1;
const u64 zx = z1 * x1;
const u64 xy = x1 * y1;
volume += x1 * yz;
first_x += x2 * yz;
first_y += y2 * zx;
first_z += z2 * xy;
second_xx += x3 * yz;
second_yy += y3 * zx;
second_zz += z3 * xy;
second_xy += x2 * y2 * z1;
second_yz += y2 * z2 * x1;
second_zx += z2 * x2 * y1;
area_x += x0 * yz;
area_y += y0 * zx;
area_z += z0 * xy;
length_x += x1 * y0 * z0;
length_y += y1 * z0 * x0;
length_z += z1 * x0 * y0;

// Adds a vertex, or an end of the tile, to the sums.
// Reads: mask, bit, j, k, open, bound. Writes: the sums.

u32 weights = weights_of[mask];
if (open != U64(0u)) { // the upper ends of the tile are no boundary
  if (bit == nx) weights = on_end(weights, 0u, 1u, 2u);
  if (j == ny) weights = on_end(weights, 1u, 0u, 2u);
  if (k == nz) weights = on_end(weights, 2u, 0u, 1u);
}
const u64 x = U64(FIELD(origin, 0u) - 1u + bound[bit]);
const u64 y = U64(FIELD(origin, 1u) - 1u + bound[32u + j]);
const u64 z = U64(FIELD(origin, 2u) - 1u + bound[64u + k]);
const u64 xy = x * y;
const u64 yz = y * z;
const u64 zx = z * x;
const u64 xyz = weight(weights, WEIGHT_VOLUME, WEIGHT_VOLUME_BITS, WEIGHT_VOLUME_BIAS) * (xy * z);
const u64 of_x = xyz * x;
const u64 of_y = xyz * y;
const u64 of_z = xyz * z;
volume += xyz;
first_x += of_x;
first_y += of_y;
first_z += of_z;
second_xx += of_x * x;
second_yy += of_y * y;
second_zz += of_z * z;
second_xy += of_x * y;
second_yz += of_y * z;
second_zx += of_z * x;
area_x += weight_of_area(weights, 0u) * yz;
area_y += weight_of_area(weights, 1u) * zx;
area_z += weight_of_area(weights, 2u) * xy;
length_x += weight_of_length(weights, 0u) * x;
length_y += weight_of_length(weights, 1u) * y;
length_z += weight_of_length(weights, 2u) * z;
vertices += U64((weights >> WEIGHT_VERTEX) & 1u);
extreme += U64((weights >> WEIGHT_EXTREME) & 1u);

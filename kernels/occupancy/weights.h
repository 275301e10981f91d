// The weights of an octant mask (include/boxunion/octants.hpp), as contract.h packs them.

#define AREA_AT(axis) (WEIGHT_AREA + WEIGHT_AREA_BITS * (axis))
#define LENGTH_AT(axis) (WEIGHT_LENGTH + WEIGHT_LENGTH_BITS * (axis))

// Weights that are all zero.
#define NO_WEIGHTS                                                                                            \
  ((WEIGHT_VOLUME_BIAS << WEIGHT_VOLUME) | (WEIGHT_AREA_BIAS << AREA_AT(0u)) |                                \
   (WEIGHT_AREA_BIAS << AREA_AT(1u)) | (WEIGHT_AREA_BIAS << AREA_AT(2u)) | (WEIGHT_LENGTH_BIAS << LENGTH_AT(0u)) | \
   (WEIGHT_LENGTH_BIAS << LENGTH_AT(1u)) | (WEIGHT_LENGTH_BIAS << LENGTH_AT(2u)))

FN u64 weight(const u32 weights, const u32 at, const u32 bits, const u32 bias) {
  return U64((weights >> at) & ((1u << bits) - 1u)) - U64(bias);
}
FN u64 weight_of_area(const u32 weights, const u32 axis) {
  return weight(weights, AREA_AT(axis), WEIGHT_AREA_BITS, WEIGHT_AREA_BIAS);
}
FN u64 weight_of_length(const u32 weights, const u32 axis) {
  return weight(weights, LENGTH_AT(axis), WEIGHT_LENGTH_BITS, WEIGHT_LENGTH_BIAS);
}

// The weights of a point at the upper end of the tile on one axis. It is not a vertex there, and not an end
// of the tile's face across that axis or of an edge along the other two.
FN u32 on_end(const u32 weights, const u32 axis, const u32 other, const u32 third) {
  const u32 flags = (1u << WEIGHT_VERTEX) | (1u << WEIGHT_EXTREME);
  const u32 area = ((1u << WEIGHT_AREA_BITS) - 1u) << AREA_AT(axis);
  const u32 length = (1u << WEIGHT_LENGTH_BITS) - 1u;
  const u32 of_end = area | (length << LENGTH_AT(other)) | (length << LENGTH_AT(third));
  return (weights & ~(of_end | flags)) | (NO_WEIGHTS & of_end);
}

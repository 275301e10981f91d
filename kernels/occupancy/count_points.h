// Stage: counts the intervals that boxes may fill, 0 .. nx, and the points: the same number, and one more at
// an upper end of the tile where sums end.
// Reads: points, open. Defines: nx, ny, nz, points_x, points_y, points_z. Writes: bound.

const u32 nx = points[0];
const u32 ny = points[1];
const u32 nz = points[2];
#ifdef SUMS
const u32 open_x = U32(open >> PACKED_BITS) & 1u;
const u32 open_y = U32(open >> (PACKED_STRIDE + PACKED_BITS)) & 1u;
const u32 open_z = U32(open >> (2u * PACKED_STRIDE + PACKED_BITS)) & 1u;
ONE_LANE {
  if (open_x != 0u) bound[nx] = FIELD(last, 0u);
  if (open_y != 0u) bound[32u + ny] = FIELD(last, 1u);
  if (open_z != 0u) bound[64u + nz] = FIELD(last, 2u);
}
const u32 points_x = nx + open_x;
const u32 points_y = ny + open_y;
const u32 points_z = nz + open_z;
#else
const u32 points_x = nx;
const u32 points_y = ny;
const u32 points_z = nz;
#endif

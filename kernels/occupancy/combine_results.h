// Replaces the last two results of a program by one.
// Reads: operation. Writes: level, depth.

--depth;
LANES(z, nz + 1u) {
  const u64 left = level[32u * (depth - 1u) + z];
  const u64 right = level[32u * depth + z];
  level[32u * (depth - 1u) + z] = operation == STEP_INTERSECTION           ? left & right
                                  : operation == STEP_UNION                ? left | right
                                  : operation == STEP_SYMMETRIC_DIFFERENCE ? left ^ right
                                  : operation == STEP_DIFFERENCE           ? left & ~right
                                                                      : right & ~left;
}
SYNC;

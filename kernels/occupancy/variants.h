// The differences of the four kernels of cell_occupancy.k. With SUMS they give sums instead of vertices. With
// BOOLEAN cells may have programs. With both, they also tell how far cells with programs reach (REACH).

#ifdef BOOLEAN
#define PROGRAM_BUFFERS                                                        \
  IN(6, u32, program) /* of each cell: first step, number of steps */          \
  IN(7, u32, step)    /* operation, and for some first box, number of boxes */
#define PROGRAM_LOCALS SHARED(u64, level, 32u * PROGRAM_RESULTS) /* the stack of bands, [level][slice] */
#else
#define PROGRAM_BUFFERS
#define PROGRAM_LOCALS
#endif

#if defined(SUMS) && defined(BOOLEAN)
#define REACH
#define SUM_STRIDE SUM_WORDS_WITH_PROGRAMS
#define WEIGHTS_BUFFER IN(WEIGHTS_BINDING_WITH_PROGRAMS, u32, weights_of)
#define REACH_LOCALS                                                                                   \
  SHARED(u32, filled, 3) /* of each axis: the intervals in which the cell has anything */              \
  SHARED(u32, reach, 6)  /* of the cells so far that have a program: lowest and highest coordinates */
#elif defined(SUMS)
#define SUM_STRIDE SUM_WORDS
#define WEIGHTS_BUFFER IN(WEIGHTS_BINDING, u32, weights_of)
#define REACH_LOCALS
#endif

#ifdef SUMS
#define RESULT_BUFFER OUT(4, u64, sum) // SUM_STRIDE words a run, see contract.h
#define SUMS_LOCALS SHARED_REDUCTION(u64, lanes) REACH_LOCALS
#define RESERVE(count) // sums need no reservation
#include "occupancy/weights.h"
#else
#define RESULT_BUFFER OUT(4, u32, vertex) // x, y, z (ordinals), octant mask
#define WEIGHTS_BUFFER
#define SUMS_LOCALS
// Reserves places for vertices. WRITE_VERTEX then writes them one by one; x, y, z count from the origin of
// the cell.
#define RESERVE(count)                                     \
  GLOBAL_FETCH_ADD(reserved, total[TOTAL_FOUND], count);   \
  u32 slot = reserved;
#define WRITE_VERTEX(x, y, z, mask)                                                   \
  if (slot < p.capacity) {                                                            \
    vertex[VERTEX_WORDS * slot] = run[RUN_WORDS * unit + 2u] + FIELD(origin, 0u) + (x);      \
    vertex[VERTEX_WORDS * slot + 1u] = run[RUN_WORDS * unit + 3u] + FIELD(origin, 1u) + (y); \
    vertex[VERTEX_WORDS * slot + 2u] = run[RUN_WORDS * unit + 4u] + FIELD(origin, 2u) + (z); \
    vertex[VERTEX_WORDS * slot + 3u] = (mask);                                        \
  }                                                                                   \
  ++slot;
#endif

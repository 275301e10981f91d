// The contract between the host and the kernels: every number, order and record on which both sides must
// agree, defined here and nowhere else. C++, OpenCL C and GLSL read it. So it has only macros: unsigned
// literals, and the members of parameter blocks, which need a type u32.
#ifndef BOXUNION_CONTRACT_H
#define BOXUNION_CONTRACT_H

// ---- every kernel ----

#define GROUP_LANES 128u // maximum lanes of a work unit (the size of SHARED_REDUCTION)

// The words of a buffer `total`.
#define TOTAL_FOUND 0u     // vertices found so far, even if they did not fit
#define TOTAL_CUT_SHORT 1u // units whose loops the device cut short
#define TOTAL_WORDS 2u

// ---- packed coordinates (core/cells/packed.hpp, cell.h) ----

#define PACKED_BITS 20u         // bits of a coordinate
#define PACKED_STRIDE 21u       // distance of coordinates: above each is a guard bit
#define PACKED_MOST 0xfffffu    // the largest coordinate
#define PACKED_GUARDS_LOW 0x00100000u // bits 20, 41 and 62: the lower and the upper half of the word
#define PACKED_GUARDS_HIGH 0x40000200u

// ---- cells (core/cells/cells.hpp, cell_occupancy.k, cell_faces.k) ----

#define CELL_RANKS 30u // maximum distinct coordinates that a cell owns on an axis

// Records, in words of their type.
#define CELL_WORDS 3u    // u64: lo - 1, size + 1, first item | number of items << 32
#define RUN_WORDS 5u     // u32: first cell, number of cells, origin x y z
#define VERTEX_WORDS 4u  // u32: x, y, z, octant mask
#define PROGRAM_WORDS 2u // u32: first step, number of steps
#define STEP_WORDS 3u    // u32: operation, first box, number of boxes

// The binding of the buffer of weights, if there is one. It comes after the buffers of programs, if there are
// any.
#define WEIGHTS_BINDING 6u
#define WEIGHTS_BINDING_WITH_PROGRAMS 8u

#define CELL_PARAMETERS                                       \
  u32 first_run;                                              \
  u32 end_run;                                                \
  u32 capacity; /* vertices that fit the output */            \
  u32 two;      /* 2, see COUNT_CUT_LOOPS */

// Operations of a program. The first three have a range of the cell's boxes.
#define STEP_PUSH 0u  // an empty result, to which the boxes are added
#define STEP_UNITE 1u // the boxes are added to the last result
#define STEP_CARVE 2u // the boxes are taken out of the last result
#define STEP_COMPLEMENT 3u
#define STEP_INTERSECTION 4u // of the last two results, like those below
#define STEP_UNION 5u
#define STEP_SYMMETRIC_DIFFERENCE 6u
#define STEP_DIFFERENCE 7u
#define STEP_REVERSED_DIFFERENCE 8u

#define PROGRAM_RESULTS 16u // maximum results of a program at a time

// The sums of a run, in order: those of LatticeSums and, if cells may have programs, the reach of cells with
// a program.
#define SUM_VERTICES 0u
#define SUM_EXTREME 1u
#define SUM_VOLUME 2u
#define SUM_FIRST 3u   // x, y, z
#define SUM_SECOND 6u  // xx, yy, zz, xy, yz, zx
#define SUM_AREA 12u   // x, y, z
#define SUM_LENGTH 15u // x, y, z
#define SUM_WORDS 18u
#define SUM_LOWEST 18u  // packed; 2^20 - 1 if there is none
#define SUM_HIGHEST 19u // packed; 0 if there is none
#define SUM_WORDS_WITH_PROGRAMS 20u

// The packed weights of an octant mask: two flags, then each weight plus a bias that makes it positive, with
// x, y, z side by side.
#define WEIGHT_VERTEX 0u
#define WEIGHT_EXTREME 1u
#define WEIGHT_VOLUME 2u
#define WEIGHT_VOLUME_BITS 4u
#define WEIGHT_VOLUME_BIAS 4u
#define WEIGHT_AREA 6u
#define WEIGHT_AREA_BITS 3u
#define WEIGHT_AREA_BIAS 2u
#define WEIGHT_LENGTH 15u
#define WEIGHT_LENGTH_BITS 2u
#define WEIGHT_LENGTH_BIAS 1u

// ---- contours (host/engine/contour_stage.hpp, contour.k) ----

#define CONTOUR_RANKS 31u            // maximum distinct coordinates that a tile owns on an axis
#define CONTOUR_CROWDED 0xffffffffu  // instead of a number of vertices: the tile owns more coordinates
#define CONTOUR_TILE_WORDS 6u        // u32: x_lo, y_lo, x_hi, y_hi, first rectangle, number of rectangles
#define CONTOUR_RECTANGLE_WORDS 4u   // u32: x_lo, y_lo, x_hi, y_hi
#define CONTOUR_FOUND_WORDS 2u       // u32: first vertex, number of vertices or CONTOUR_CROWDED
#define CONTOUR_VERTEX_WORDS 3u      // u32: x, y, quadrant mask

#define CONTOUR_PARAMETERS                                    \
  u32 tiles;                                                  \
  u32 capacity; /* vertices that fit the output */            \
  u32 two;      /* 2, see COUNT_CUT_LOOPS */

// ---- copies (host/bench/kernel_bench.cpp, copy.k) ----

#define COPY_CHUNK 1024u // words that a work unit copies

#define COPY_PARAMETERS u32 words;

#endif // BOXUNION_CONTRACT_H

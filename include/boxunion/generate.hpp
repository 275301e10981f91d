#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/export.hpp"
#include "boxunion/volume.hpp"

namespace boxunion {

/// Receives the boxes of a generator, block by block, in order.
using BoxBlockSink = std::function<void(std::span<const IntegerBox>)>;

/// A set of boxes that is computed on demand, so that any number of boxes can be written with little memory.
/// The boxes are the same on every machine; random ones use the raw output of std::mt19937_64.
struct BoxGenerator {
  std::uint64_t count = 0;                       ///< total number of boxes
  std::function<void(const BoxBlockSink&)> run;  ///< passes all boxes to a sink; may be called again
};

// The generators throw Error(usage) for parameters out of range. All lengths are in units of the lattice.

/// Cubes of one edge inside [0, universe]^3. Each low coordinate is next() % (universe - edge + 1): x, then
/// y, then z, cube after cube. 1 <= edge <= universe <= 2^31 - 1.
BOXUNION_API BoxGenerator generate_cubes(std::uint64_t count, std::int64_t edge, std::int64_t universe,
                                         std::uint64_t seed);

/// Boxes of random edges inside [0, universe]^3. For x, then y, then z, box after box, the edge is min_edge +
/// next() % (max_edge - min_edge + 1), and the low coordinate is next() % (universe - edge + 1). 0 <=
/// min_edge <= max_edge <= universe <= 2^31 - 1. An edge of 0 makes a degenerate box.
BOXUNION_API BoxGenerator generate_boxes(std::uint64_t count, std::int64_t min_edge, std::int64_t max_edge,
                                         std::int64_t universe, std::uint64_t seed);

/// The unit cubes of a size^3 grid whose x + y + z is even, sorted by z, y, x. 1 <= size <= 2 000 000.
BOXUNION_API BoxGenerator generate_checkerboard(std::int64_t size);

/// The 20^level unit cubes of the Menger sponge in [0, 3^level]^3. 0 <= level <= 14.
BOXUNION_API BoxGenerator generate_sponge(int level);

/// All boxes of a generator in memory.
BOXUNION_API std::vector<IntegerBox> collect(const BoxGenerator& generator);

// Volumes for tests and benchmarks, computed in integers only, so they are the same on every machine. `size`
// is the number of voxels along x, y and z, each 1 to 2^31 - 1. Parallel. They throw Error(usage) for
// parameters out of range, and Error(resources).

/// The ten ellipsoids of the three-dimensional Shepp-Logan head phantom (Kak and Slaney, Principles of
/// Computerized Tomographic Imaging, 1988), stretched to the volume. A voxel is inside if its centre lies in
/// an odd number of them. This gives a shell (the skull) with separate and overlapping bodies inside.
BOXUNION_API Volume generate_phantom(const std::array<std::int64_t, 3>& size);

/// The shape of a porous block.
struct Porosity {
  double pores = 0.5;        ///< fraction of voxels outside, 0 to 1, as closely as ties allow
  std::int64_t feature = 9;  ///< width of the pores and walls in voxels, 1 (single voxels) to 255
};

/// A porous block. Random numbers (splitmix64 of seed and voxel) are averaged three times over `feature`
/// voxels along each axis, as if the volume repeated itself. Voxels from the quantile `pores` on are inside.
BOXUNION_API Volume generate_porous(const std::array<std::int64_t, 3>& size, const Porosity& porosity,
                                    std::uint64_t seed);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>

#include "core/voxels/volume.hpp"

namespace boxunion {

// Volumes for tests and benchmarks, computed in integers alone, so they are the same on every machine. `size`
// is the number of voxels along x, y and z, each 1 to 2^31 - 1. Parallel. They throw Error(usage) for
// parameters out of range and Error(resources).

/// The ten ellipsoids of the three-dimensional Shepp-Logan head phantom (Kak and Slaney, Principles of
/// Computerized Tomographic Imaging, 1988), stretched to the volume: a voxel is inside if its centre lies in
/// an odd number of them. So there is a shell (the skull) with separate and overlapping bodies in it.
Volume generate_phantom(const std::array<std::int64_t, 3>& size);

/// What a porous block looks like.
struct Porosity {
  double pores = 0.5;  ///< fraction of the voxels that are outside, 0 to 1, met as closely as ties allow
  std::int64_t feature = 9;  ///< width of the pores and walls in voxels, 1 (single voxels) to 255
};

/// A porous block: random numbers (splitmix64 of seed and voxel), thrice averaged over `feature` voxels along
/// each axis as if the volume repeated itself, inside from the quantile `pores` on.
Volume generate_porous(const std::array<std::int64_t, 3>& size, const Porosity& porosity, std::uint64_t seed);

}  // namespace boxunion

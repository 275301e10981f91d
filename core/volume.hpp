#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "core/memory.hpp"

namespace boxunion {

/// How many voxels a volume has and where they lie. Edge k of the volume's axis a, for k = 0 .. size[a], is
/// at origin[a] + k spacing[a] on coordinate axis axes[a], so voxel i lies between edges i and i + 1.
struct VoxelGrid {
  std::array<std::size_t, 3> size{};         ///< voxels along each axis, the fastest axis first
  std::array<double, 3> origin{};            ///< of the first edge
  std::array<double, 3> spacing{1, 1, 1};    ///< edge of a voxel; negative where the axis runs backwards
  std::array<std::size_t, 3> axes{0, 1, 2};  ///< coordinate axis (x, y, z = 0, 1, 2) of each axis

  std::size_t slice() const { return size[0] * size[1]; }
  std::size_t voxels() const { return slice() * size[2]; }
  /// Coordinate of edge k of axis a, rounded once.
  double edge(std::size_t a, std::int64_t k) const { return std::fma(double(k), spacing[a], origin[a]); }
};

/// The voxels of a volume, to be read once, slice by slice, so that they are never all in memory.
struct VoxelStream {
  VoxelGrid grid;
  /// Fills a span of whole slices with the next ones: for each voxel 1 if it is inside, else 0.
  std::function<void(std::span<std::uint8_t>)> read;
};

/// A volume in memory.
struct Volume {
  VoxelGrid grid;
  Array<std::uint8_t> inside;  ///< not 0 for voxels inside; the first axis runs fastest
};

/// Slices to read at once: a few million voxels, at least one slice.
std::size_t slices_at_once(const VoxelGrid& grid);

/// Reads a whole stream into memory. Throws Error(resources) if it does not fit.
Volume collect(const VoxelStream& stream);

/// A stream of the slices of a volume, which must outlive it.
VoxelStream stream_of(const Volume& volume);

/// The same voxels with the last axis running fastest.
Volume transposed(const Volume& volume);

}  // namespace boxunion

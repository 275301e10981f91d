#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "boxunion/array.hpp"
#include "boxunion/error.hpp"
#include "boxunion/export.hpp"

namespace boxunion {

/// Which boxes or voxels are neighbors.
enum class Connectivity {
  faces = 6,   ///< those that share a part of a face
  points = 26  ///< those that share any point
};

/// Throws Error(usage) for any other value.
inline void validate(Connectivity connectivity) {
  if (connectivity != Connectivity::faces && connectivity != Connectivity::points)
    throw Error(ErrorKind::usage,
                "connectivity is " + std::to_string(int(connectivity)) + ", expected 6 or 26");
}

/// The size and place of a volume. Edge k of the volume's axis a, for k = 0 .. size[a], is at origin[a] + k
/// spacing[a] on coordinate axis axes[a], so voxel i lies between edges i and i + 1.
struct VoxelGrid {
  std::array<std::size_t, 3> size{};         ///< voxels along each axis, the fastest axis first
  std::array<double, 3> origin{};            ///< of the first edge
  std::array<double, 3> spacing{1, 1, 1};    ///< edge of a voxel; negative if the axis runs backwards
  std::array<std::size_t, 3> axes{0, 1, 2};  ///< coordinate axis (x, y, z = 0, 1, 2) of each axis

  std::size_t slice() const { return size[0] * size[1]; }
  std::size_t voxels() const { return slice() * size[2]; }
  /// The coordinate of edge k of axis a, rounded once.
  double edge(std::size_t a, std::int64_t k) const { return std::fma(double(k), spacing[a], origin[a]); }
};

/// The voxels of a volume as a stream. They are read once, slice by slice, and are never all in memory.
struct VoxelStream {
  VoxelGrid grid;
  /// Fills a span with the next slices: 1 for a voxel inside, 0 for one outside. The span must have whole
  /// slices.
  std::function<void(std::span<std::uint8_t>)> read;
};

/// A volume in memory.
struct BOXUNION_API Volume {
  Volume() = default;
  /// A volume of zeros: no voxel is inside. Parallel. Throws Error(usage) as validate does, and
  /// Error(resources) if it does not fit.
  explicit Volume(const VoxelGrid& grid);

  VoxelGrid grid;
  /// The voxels of the grid, not 0 for those inside. The first axis runs fastest. resize() of an Array does
  /// not set elements; only the constructor and assign() do.
  Array<std::uint8_t> inside;
};

/// Throws Error(usage) unless the three axes of a grid are x, y and z, in any order, each axis has at most
/// 2^31 - 1 voxels, and the number of all voxels fits 60 bits.
BOXUNION_API void validate(const VoxelGrid& grid);
/// Throws Error(usage) unless the grid is valid and the volume has as many voxels as the grid.
BOXUNION_API void validate(const Volume& volume);

/// The number of slices to read at once: a few million voxels, at least one slice.
BOXUNION_API std::size_t slices_at_once(const VoxelGrid& grid);

/// Reads a whole stream into memory. Throws Error(resources) if it does not fit.
BOXUNION_API Volume collect(const VoxelStream& stream);

/// A stream of the slices of a volume, which must outlive the stream. Throws Error(usage) for an invalid
/// volume.
BOXUNION_API VoxelStream stream_of(const Volume& volume);

/// The same voxels with the last axis running fastest. Throws Error(usage) for an invalid volume.
BOXUNION_API Volume transposed(const Volume& volume);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/export.hpp"
#include "boxunion/volume.hpp"

namespace boxunion {

/// Boxes without common interior whose union is that of the voxels inside, in the coordinates of the volume's
/// grid. They are 32-bit integers if origin and spacing are whole numbers and all edges fit, otherwise
/// doubles, with each edge rounded once. Parallel.
///
/// Throws Error(input) if an edge exceeds the range of double, Error(usage) for an invalid grid.
BOXUNION_API BoxSet voxel_boxes(const VoxelStream& stream);

/// A connected component of the voxels inside.
struct VoxelComponent {
  std::uint64_t voxels = 0;
  std::array<std::uint32_t, 3> first{};  ///< lowest voxel on each axis
  std::array<std::uint32_t, 3> last{};   ///< highest voxel on each axis

  friend bool operator==(const VoxelComponent&, const VoxelComponent&) = default;
};

/// Labels the connected components of the voxels inside. Each voxel of `labels`, which must have as many as
/// the volume, gets the number of its component, counted from 1 in the order of their first voxels, or 0 if
/// it is outside. Returns the components in that order.
///
/// Works on runs along the first axis: two passes with a union-find over runs of neighboring rows that
/// overlap. Besides the volumes it needs 12 bytes per run. Parallel. The result does not depend on the
/// threads. Throws Error(resources) if there are 2^32 - 1 runs or more, Error(usage) for an invalid volume or
/// if `labels` has another size.
BOXUNION_API std::vector<VoxelComponent> label_voxels(const Volume& volume, Connectivity connectivity,
                                                      std::span<std::uint32_t> labels);

}  // namespace boxunion

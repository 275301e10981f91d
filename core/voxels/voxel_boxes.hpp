#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/volume.hpp"
#include "boxunion/voxels.hpp"

namespace boxunion {

/// Boxes without common interior whose union is that of the voxels inside.
///
/// Runs along x that repeat from row to row become rectangles. Rectangles that repeat from slice to slice
/// become boxes. This is the CUDB decomposition (Cruz-Matías and Ayala) in the order z, y, x, made while the
/// slices stream by, with memory for the boxes and a few slices. The boxes are sorted by z, y, x of their
/// first voxels, in units of voxels along the axes of the volume: voxel (i, j, k) is the box from (i, j, k)
/// to (i + 1, j + 1, k + 1). Parallel.
std::vector<IntegerBox> index_boxes(const VoxelStream& stream);

/// Passes the same boxes to `take`, some at a time, when the slices have passed them. Only boxes that reach
/// the current slice, and a few slices, are in memory. Throws as voxel_boxes does.
void stream_voxel_boxes(const VoxelStream& stream, const std::function<void(const BoxSet&)>& take);

/// About the memory that streaming may take, for any voxels.
std::uint64_t stream_bytes(const VoxelGrid& grid);

}  // namespace boxunion

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
/// Runs along x that repeat from row to row become rectangles, rectangles that repeat from slice to slice
/// become boxes: the CUDB decomposition (Cruz-Matías and Ayala) in the order z, y, x, made while the slices
/// stream by, with memory for the boxes and a few slices. Sorted by the first voxel's z, y, x. In units of
/// voxels along the volume's axes: voxel (i, j, k) is the box from (i, j, k) to (i + 1, j + 1, k + 1).
/// Parallel.
std::vector<IntegerBox> index_boxes(const VoxelStream& stream);

/// Gives the same boxes to `take`, some at a time, as the slices pass them: only those that reach the slice
/// and a few slices are in memory. Throws as voxel_boxes does.
void stream_voxel_boxes(const VoxelStream& stream, const std::function<void(const BoxSet&)>& take);

/// The memory that streaming may take, about, whatever the voxels are.
std::uint64_t stream_bytes(const VoxelGrid& grid);

}  // namespace boxunion

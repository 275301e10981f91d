#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/connectivity.hpp"
#include "core/models/adjacency.hpp"
#include "core/models/decomposition.hpp"
#include "core/voxels/voxel_labels.hpp"

namespace boxunion {

/// Labels of boxes: those of one connected component have the same one.
struct Labels {
  std::vector<std::uint32_t> labels;  ///< by box: 1 .. count, in the order of the components' first boxes
  std::uint32_t count = 0;
};

/// Labels boxes by union-find over their neighbor lists (instead of the two passes with a map of
/// equivalences of Cruz-Matías and Ayala, section 3.5). Parallel; the same labels on any number of threads.
Labels label_components(const Adjacency& adjacency);
/// The same without the lists, of which n boxes may have n^2: over as many pairs of neighbors as connect
/// them all, in about n log n time. Throws Error(resources) if memory does not suffice.
Labels label_components(const Decomposition& decomposition, Connectivity connectivity);

/// A connected component of a union of disjoint boxes.
struct Component {
  std::uint64_t boxes = 0;
  double volume = 0;                              ///< exact, rounded once
  std::array<std::array<double, 3>, 2> bounds{};  ///< x, y, z
};

/// The components of labelled boxes, in the order of the labels. Parallel. Throws Error(usage) unless there
/// is a label from 1 to the count for each box.
std::vector<Component> measure_components(const Decomposition& decomposition, const Labels& labels);

/// The same of components of voxels, each a box; the volume is that of so many voxels, rounded once.
std::vector<Component> measure_components(const VoxelGrid& grid, std::span<const VoxelComponent> components);

}  // namespace boxunion

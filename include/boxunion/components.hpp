#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/array.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/export.hpp"
#include "boxunion/volume.hpp"
#include "boxunion/voxels.hpp"

namespace boxunion {

/// A list of other boxes for each box, in flat arrays: box i has boxes[offsets[i]] .. boxes[offsets[i + 1] -
/// 1], ascending.
struct NeighborLists {
  Array<std::uint64_t> offsets;
  Array<std::uint32_t> boxes;

  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return std::span(boxes).subspan(offsets[i], offsets[i + 1] - offsets[i]);
  }
};

/// The neighbors of the boxes of a decomposition (Cruz-Matías and Ayala, section 3), across their ends on A
/// and on B. No two boxes touch along C alone. Two boxes are neighbors on one axis at most: boxes that meet
/// at an edge or a corner, at the end of both A and B, are neighbors on A.
struct Adjacency {
  std::array<NeighborLists, 2> backward, forward;  ///< on A and on B

  /// The number of pairs of neighbors.
  std::uint64_t pairs() const { return forward[0].boxes.size() + forward[1].boxes.size(); }
  /// The memory of the lists, and of lists for so many boxes and pairs.
  std::uint64_t bytes() const {
    return bytes_of(std::max<std::size_t>(forward[0].offsets.size(), 1) - 1, pairs());
  }
  static constexpr std::uint64_t bytes_of(std::uint64_t boxes, std::uint64_t pairs) {
    return 4 * (boxes + 1) * sizeof(std::uint64_t) + 2 * pairs * sizeof(std::uint32_t);
  }
};

/// Finds all neighbors in about O(n log n) time for n boxes and pairs. Parallel. Throws Error(resources) if
/// memory does not suffice.
BOXUNION_API Adjacency find_neighbors(const Decomposition& decomposition, Connectivity connectivity);

/// Labels of boxes. The boxes of a connected component have the same label.
struct Labels {
  std::vector<std::uint32_t> labels;  ///< by box: 1 .. count, in the order of the components' first boxes
  std::uint32_t count = 0;
};

/// Labels boxes by union-find over their neighbor lists (instead of the two passes with a map of equivalences
/// of Cruz-Matías and Ayala, section 3.5). Parallel. The labels do not depend on the number of threads.
BOXUNION_API Labels label_components(const Adjacency& adjacency);
/// The same without the lists, which may have n^2 entries for n boxes. Joins only as many pairs of neighbors
/// as are needed, in about O(n log n) time. Throws Error(resources) if memory does not suffice.
BOXUNION_API Labels label_components(const Decomposition& decomposition, Connectivity connectivity);

/// A connected component of a union of disjoint boxes.
struct Component {
  std::uint64_t boxes = 0;
  double volume = 0;                              ///< exact, rounded once
  std::array<std::array<double, 3>, 2> bounds{};  ///< x, y, z
};

/// The components of labelled boxes, in the order of the labels. Parallel. Throws Error(usage) unless each
/// box has a label from 1 to the count.
BOXUNION_API std::vector<Component> measure_components(const Decomposition& decomposition,
                                                       const Labels& labels);

/// The same for components of voxels. Their boxes are voxels, and the volume is that of the voxels, rounded
/// once.
BOXUNION_API std::vector<Component> measure_components(const VoxelGrid& grid,
                                                       std::span<const VoxelComponent> components);

}  // namespace boxunion

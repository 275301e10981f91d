#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/cells/packed.hpp"
#include "core/cells/touching_pairs.hpp"

namespace boxunion {

/// The clusters of a tile's boxes: the connected components of "touch each other within the tile".
///
/// A cluster is a union of its own, whatever lies around it, so it needs no cell of a grid. Most sparse boxes
/// are lone: clusters of one. A sweep along x finds the clusters. On its way, a box meets those that begin
/// before it ends; their y and z are compared in one subtraction, as in packed.hpp. If boxes are so long that
/// a sweep would take too many comparisons, but few seem to touch, TouchingPairs finds those that do.
class Clusters {
 public:
  /// Clusters with more boxes are left to a grid.
  static constexpr std::uint32_t kMostBoxes = 15;

  /// Finds the clusters of boxes in a tile whose longest edge is `edge`. Returns false and finds nothing if
  /// so many boxes meet that other ways are faster. Takes O(boxes + min(edge, 4096)) time.
  bool find(std::span<const PackedBox> boxes, std::uint32_t edge);

  /// Lone boxes, by index.
  std::span<const std::uint32_t> lone() const { return lone_; }
  /// Boxes of clusters of 2 to kMostBoxes, by index, cluster after cluster.
  std::span<const std::uint32_t> members() const { return members_; }
  /// The end of each of these clusters in members().
  std::span<const std::uint32_t> ends() const { return ends_; }
  /// Boxes of larger clusters, by index.
  std::span<const std::uint32_t> rest() const { return rest_; }

 private:
  void sort(std::span<const PackedBox> boxes, std::uint32_t edge);
  template <class Lanes>
  bool join_touching(std::span<const PackedBox> boxes);
  bool join_touching_with_avx2(std::span<const PackedBox> boxes);
  bool join_by_division(std::span<const PackedBox> boxes);
  void join(std::uint32_t i, std::uint32_t j);
  void gather();
  std::uint32_t root(std::uint32_t i);

  std::vector<std::uint32_t> lone_, members_, ends_, rest_;

  // boxes in the order of their low x
  std::vector<std::uint32_t> bucket_end_;  // by low x: the place behind its boxes
  std::vector<std::uint32_t> index_;
  std::vector<std::uint32_t> lo_, hi_;  // y and z in 15 bits each, below guard bits
  std::vector<std::uint32_t> last_;     // bucket of the high x
  std::vector<std::uint32_t> parent_;   // a forest whose trees are the clusters; roots come first
  std::vector<std::uint32_t> size_;     // size of the cluster, by root
  std::vector<std::uint32_t> next_;     // place of the next box in members_, by root
  TouchingPairs pairs_;
};

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/cells/packed.hpp"
#include "core/cells/touching_pairs.hpp"

namespace boxunion {

/// The clusters of a tile's boxes: the connected components of "touch each other within the tile".
///
/// A cluster is a union of its own, whatever lies around it, so it needs no cell of a grid. Of sparse boxes
/// most are lone, clusters of one. Found by a sweep along x, in which a box meets those that begin before it
/// ends; their y and z are compared in one subtraction, as in packed.hpp. Where boxes are so long that this
/// would take too many comparisons, but few seem to touch, TouchingPairs finds those that do.
class Clusters {
 public:
  /// A cluster with more boxes than this is left to a grid.
  static constexpr std::uint32_t kMostBoxes = 15;

  /// Finds the clusters of boxes in a tile whose longest edge is `edge`. False, with nothing found, where so
  /// many boxes meet that other ways are quicker. Takes O(boxes + edge up to 4096).
  bool find(std::span<const PackedBox> boxes, std::uint32_t edge);

  /// Lone boxes, by index.
  std::span<const std::uint32_t> lone() const { return lone_; }
  /// Boxes of clusters of 2 to kMostBoxes, by index, cluster after cluster.
  std::span<const std::uint32_t> members() const { return members_; }
  /// Where each of those clusters ends in members().
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

  // boxes in order of their low x, by place
  std::vector<std::uint32_t> bucket_end_;  // of low x: the place behind its boxes
  std::vector<std::uint32_t> index_;
  std::vector<std::uint32_t> lo_, hi_;  // y and z in 15 bits each, below guard bits
  std::vector<std::uint32_t> last_;     // bucket of the high x
  std::vector<std::uint32_t> parent_;   // a forest whose trees are the clusters; roots come first
  std::vector<std::uint32_t> size_;     // of a root's cluster
  std::vector<std::uint32_t> next_;     // of a root: where its next box goes in members_
  TouchingPairs pairs_;
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/connectivity.hpp"
#include "core/base/memory.hpp"
#include "core/models/decomposition.hpp"

namespace boxunion {

/// For each box a list of others, in flat arrays: box i has boxes[offsets[i]] .. boxes[offsets[i + 1] - 1],
/// ascending.
struct NeighborLists {
  Array<std::uint64_t> offsets;
  Array<std::uint32_t> boxes;

  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return std::span(boxes).subspan(offsets[i], offsets[i + 1] - offsets[i]);
  }
};

/// The neighbors of the boxes of a decomposition (Cruz-Matías and Ayala, section 3): across their ends on A
/// and on B. None of its boxes touch along C alone. Two boxes are neighbors on one axis at most: those that
/// meet at an edge or a corner, at the end of both A and B, are so on A.
struct Adjacency {
  std::array<NeighborLists, 2> backward, forward;  ///< on A and on B

  /// Pairs of neighbors.
  std::uint64_t pairs() const { return forward[0].boxes.size() + forward[1].boxes.size(); }
  /// The memory of the lists, and of those of so many boxes and pairs.
  std::uint64_t bytes() const {
    return bytes_of(std::max<std::size_t>(forward[0].offsets.size(), 1) - 1, pairs());
  }
  static constexpr std::uint64_t bytes_of(std::uint64_t boxes, std::uint64_t pairs) {
    return 4 * (boxes + 1) * sizeof(std::uint64_t) + 2 * pairs * sizeof(std::uint32_t);
  }
};

/// Finds all neighbors in about n log n time for n boxes and pairs. Parallel. Throws Error(resources) if
/// memory does not suffice.
Adjacency find_neighbors(const Decomposition& decomposition, Connectivity connectivity);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>

#include "boxunion/octants.hpp"
#include "core/boundary/planes.hpp"
#include "core/solid/fans.hpp"

namespace boxunion {

/// Counts of the boundary that follow from the vertices alone: sums over their octant masks.
class VertexCounts {
 public:
  void add(unsigned mask) {
    ++vertices;
    for (const int direction : {0, 2, 4}) {  // count each edge at its lower end
      edges += kOctants[mask].edges[direction] != 0;
      nonmanifold_edges += kOctants[mask].edges[direction] == 2;
    }
    fans += kFans[mask].count;
    for (const auto& filled : kFilledQuadrants) filled_quadrants_ += filled[mask];
  }

  std::uint64_t vertices = 0, edges = 0, nonmanifold_edges = 0;
  std::uint64_t fans = 0;
  /// The number of triangles if contacts are kept. Each midpoint of a split edge adds two.
  std::uint64_t triangles() const { return filled_quadrants_ / 2; }

 private:
  std::uint64_t filled_quadrants_ = 0;
};

}  // namespace boxunion

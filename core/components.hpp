#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/adjacency.hpp"
#include "core/decomposition.hpp"

namespace boxunion {

/// Connected components of a union of disjoint boxes.
struct Components {
  /// One component.
  struct Properties {
    double volume = 0;                              ///< exact, rounded once
    std::array<std::array<double, 3>, 2> bounds{};  ///< x, y, z
    std::uint64_t boxes = 0;
  };
  std::vector<std::uint32_t> labels;   ///< by box: 1 .. components.size(), in the order of their first boxes
  std::vector<Properties> components;  ///< component i has label i + 1
};

/// Labels the boxes by union-find over their neighbour lists (instead of the two passes with a map of
/// equivalences of Cruz-Matías and Ayala, section 3.5). Parallel; the same labels on any number of threads.
Components find_components(const Decomposition& decomposition, const Adjacency& adjacency);

}  // namespace boxunion

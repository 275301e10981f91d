#pragma once

#include <array>
#include <optional>

namespace boxunion {

/// A halving of the cells of a grid along one axis.
struct Halving {
  std::array<int, 3> log_edge;  ///< of the halved cells, by axis
  double per_box;               ///< average number of halved cells that a box touches
};

/// The halving that duplicates the fewest boxes; of equal ones, that along the last axis. Nothing if no edge
/// is longer than 2^least. per_box(log_edge, axis) is the estimate for a grid whose cells are halved along
/// axis.
template <class PerBox>
std::optional<Halving> cheapest_halving(const std::array<int, 3>& log_edge, int least, PerBox&& per_box) {
  std::optional<Halving> best;
  for (int a = 2; a >= 0; --a) {
    if (log_edge[a] <= least) continue;
    std::array<int, 3> halved = log_edge;
    --halved[a];
    const double here = per_box(halved, a);
    if (!best || here < best->per_box) best = {halved, here};
  }
  return best;
}

}  // namespace boxunion

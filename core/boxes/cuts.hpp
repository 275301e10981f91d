#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "boxunion/box.hpp"

namespace boxunion {

/// Planes that cut a set of boxes into slabs along one axis, as in distribution sweeping (Goodrich, Tsay,
/// Vengroff, Vitter, "External-memory computational geometry", 1993). Slab i owns the points with at[i - 1]
/// <= p < at[i]. The boxes that touch it decide everything about them: lo < at[i] and hi >= at[i - 1].
struct Cuts {
  int axis = 0;
  std::vector<double> at;  ///< ascending
  double largest = 1;      ///< fraction of the boxes in the fullest slab
  double copies = 1;       ///< average number of slabs of a box
};

/// Chooses cuts from a sample of the boxes. The slabs have equal numbers of boxes and lie along the axis that
/// gives the fewest copies. Each slab has at most the fraction `share` of the boxes, or more if boxes are
/// longer than such slabs. There are at most `most` slabs. Returns nothing if the boxes overlap so deeply
/// that no cut along any axis reduces their number much.
std::optional<Cuts> choose_cuts(std::span<const Box> sample, double share, std::size_t most);

}  // namespace boxunion

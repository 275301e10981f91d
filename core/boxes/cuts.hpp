#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/boxes/box.hpp"

namespace boxunion {

/// Planes that cut a set of boxes into slabs along one axis, as distribution sweeping does (Goodrich, Tsay,
/// Vengroff, Vitter, "External-memory computational geometry", 1993). Slab i owns the points with
/// at[i - 1] <= p < at[i]; all about them is decided by the boxes that touch it: lo < at[i], hi >= at[i - 1].
struct Cuts {
  int axis = 0;
  std::vector<double> at;  ///< ascending
  double largest = 1;      ///< fraction of the boxes that the fullest slab gets
  double copies = 1;       ///< slabs that get a box, on average
};

/// Cuts into slabs of equal numbers of boxes, along the axis on which they get the fewest copies, by a sample
/// of the boxes: each slab is to have a fraction of at most `share` of them, or more where boxes are longer
/// than such slabs, and there are at most `most` slabs. Nothing where the boxes lie so deep over each other
/// that no cut along any axis makes them notably fewer.
std::optional<Cuts> choose_cuts(std::span<const Box> sample, double share, std::size_t most);

}  // namespace boxunion

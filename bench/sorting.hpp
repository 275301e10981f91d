#pragma once

#include <tbb/parallel_sort.h>

#include <cstddef>
#include <vector>

#include "bench/timing.hpp"
#include "boxunion/box.hpp"

namespace boxunion {

/// Wall seconds of the yardstick: sorting the corner coordinates of the boxes as doubles, one sort for each
/// axis.
inline double seconds_to_sort(const BoxSet& boxes) {
  double seconds = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> corners(2 * boxes.size());
    boxes.visit([&](const auto& all) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        corners[2 * i] = double(all[i][axis]);
        corners[2 * i + 1] = double(all[i][axis + 3]);
      }
    });
    seconds += seconds_of([&] { tbb::parallel_sort(corners.begin(), corners.end()); });
  }
  return seconds;
}

}  // namespace boxunion

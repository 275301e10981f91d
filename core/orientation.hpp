#pragma once

#include <array>

namespace boxunion {

/// Which way a, b, c turn: 1 counter-clockwise, -1 clockwise, 0 if they are collinear. Exact for all finite
/// doubles.
int orientation(const std::array<double, 2>& a, const std::array<double, 2>& b,
                const std::array<double, 2>& c);

}  // namespace boxunion

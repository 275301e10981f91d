#pragma once

#include <array>
#include <cmath>

namespace boxunion {

namespace detail {
/// orientation() for cases that rounding may decide.
int exact_orientation(const std::array<double, 2>& a, const std::array<double, 2>& b,
                      const std::array<double, 2>& c);
}  // namespace detail

/// The turn from a over b to c: 1 counter-clockwise, -1 clockwise, 0 if they are collinear. Exact for all
/// finite doubles.
inline int orientation(const std::array<double, 2>& a, const std::array<double, 2>& b,
                       const std::array<double, 2>& c) {
  // The sign of ux * vy - uy * vx. Rounding changes each product by a relative 2^-51 at most, if none
  // underflows.
  const double left = (b[0] - a[0]) * (c[1] - a[1]), right = (b[1] - a[1]) * (c[0] - a[0]);
  if (std::abs(left - right) > 0x1p-50 * (std::abs(left) + std::abs(right)) + 0x1p-1000)
    return left > right ? 1 : -1;
  return detail::exact_orientation(a, b, c);
}

}  // namespace boxunion

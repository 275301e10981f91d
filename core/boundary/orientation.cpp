#include "core/boundary/orientation.hpp"

#include <cmath>

#include "core/base/exact.hpp"

namespace boxunion {
namespace {

int sign(double x) {
  return (x > 0) - (x < 0);
}

/// The difference a - b, and whether it is exact (Knuth's two-sum; not valid if it overflows).
struct Difference {
  double value;
  bool exact;

  Difference(double a, double b) : value(a - b) {
    const double b_part = a - value, a_part = value + b_part;
    exact = a - a_part == 0 && b_part - b == 0;
  }
};

}  // namespace

int detail::exact_orientation(const std::array<double, 2>& a, const std::array<double, 2>& b,
                              const std::array<double, 2>& c) {
  const Difference ux(b[0], a[0]), uy(b[1], a[1]), vx(c[0], a[0]), vy(c[1], a[1]);
  const double left = ux.value * vy.value, right = uy.value * vx.value;

  // A difference always has the right sign, even if its product underflows.
  const int left_sign = sign(ux.value) * sign(vy.value), right_sign = sign(uy.value) * sign(vx.value);
  if (left_sign != right_sign || left_sign == 0) return sign(left_sign - right_sign);

  // The factors are exact, as on a lattice. Then the products compare as their rounded values do. If these
  // are equal, they compare as their rounding errors do, which are doubles unless they underflow.
  const bool factors_exact = ux.exact && uy.exact && vx.exact && vy.exact;
  if (factors_exact && std::isfinite(left) && std::isfinite(right) && std::abs(left) > 0x1p-900) {
    if (left != right) return sign(left - right);
    return sign(std::fma(ux.value, vy.value, -left) - std::fma(uy.value, vx.value, -right));
  }

  const auto minus = [](double p, double q) { return dyadic(p) - dyadic(q); };
  const Dyadic exact = minus(b[0], a[0]) * minus(c[1], a[1]) - minus(b[1], a[1]) * minus(c[0], a[0]);
  return exact.m.sign();
}

}  // namespace boxunion

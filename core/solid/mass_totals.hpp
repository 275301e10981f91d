#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "core/base/exact.hpp"
#include "core/solid/mass_sink.hpp"

namespace boxunion {

// The implementation of MassTotals. Only .cpp files include this header, like exact.hpp.

/// The sums of a union. Each is a sum of weight * x^i * y^j * z^k over the vertices; kPowers holds (i, j, k).
inline constexpr unsigned kVolume = 0, kFirst = 1, kSecond = 4, kArea = 10, kLength = 13, kSums = 16;
inline constexpr auto kPowers = [] {
  std::array<std::array<int, 3>, kSums> powers{};
  powers[kVolume] = {1, 1, 1};
  for (unsigned a = 0; a < 3; ++a) {
    powers[kFirst + a] = powers[kSecond + a] = powers[kSecond + 3 + a] = powers[kArea + a] = {1, 1, 1};
    powers[kFirst + a][a] = 2;
    powers[kSecond + a][a] = 3;
    powers[kSecond + 3 + a][a] = powers[kSecond + 3 + a][(a + 1) % 3] = 2;
    powers[kArea + a][a] = 0;
    powers[kLength + a][a] = 1;
  }
  return powers;
}();
using Totals = std::array<Dyadic, kSums>;

/// The exponent of the product x^i * y^j * z^k of numbers with these exponents.
constexpr int product_exponent(unsigned sum, const std::array<int, 3>& exponents) {
  return kPowers[sum][0] * exponents[0] + kPowers[sum][1] * exponents[1] + kPowers[sum][2] * exponents[2];
}

struct MassTotals::Sums {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Totals totals;  // in coordinates
  std::uint64_t vertices = 0, extreme = 0;
  std::array<double, 3> lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity};
};

}  // namespace boxunion

#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace boxunion::soak {

/// The random numbers that determine a job.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// 0 .. limit - 1
  int below(int limit) { return int(std::uniform_int_distribution<int>(0, limit - 1)(engine_)); }
  bool one_in(int times) { return below(times) == 0; }
  /// Between low and high, with equal probability for each order of magnitude.
  double between(double low, double high) {
    return low * std::exp(std::uniform_real_distribution<double>(0, std::log(high / low))(engine_));
  }
  template <class T>
  const T& one_of(const std::vector<T>& values) {
    return values[std::size_t(below(int(values.size())))];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace boxunion::soak

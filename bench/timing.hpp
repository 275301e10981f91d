#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

// Clocks of the benchmarks.

namespace boxunion {

/// Wall seconds of one call.
template <class F>
double seconds_of(F&& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Small work is repeated for so many seconds, so that caches and threads are warm.
constexpr double kTurn = 0.25;

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

/// Median wall seconds of some calls.
template <class F>
double median_seconds(int runs, F&& f) {
  std::vector<double> all;
  for (int i = 0; i < runs; ++i) all.push_back(seconds_of(f));
  return median(std::move(all));
}

}  // namespace boxunion

#pragma once

#include <chrono>
#include <string_view>

#include "host/engine.hpp"

namespace boxunion {

/// Adds up the seconds of a run's stages in its report.
class Stopwatch {
 public:
  explicit Stopwatch(Report& report) : report_(report) {}

  /// Books the time since the last lap (or the start) under `stage`.
  void lap(std::string_view stage) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    for (auto& [name, sum] : report_.seconds)
      if (name == stage) {
        sum += seconds;
        return;
      }
    report_.seconds.emplace_back(stage, seconds);
  }
  /// Books the time since the start under `stage`.
  void total(std::string_view stage) {
    last_ = start_;
    lap(stage);
  }

 private:
  using Clock = std::chrono::steady_clock;
  Report& report_;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace boxunion

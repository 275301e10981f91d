#pragma once

#include <algorithm>
#include <chrono>
#include <string_view>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/base/interruptible.hpp"

namespace boxunion {

/// Adds up the seconds of the stages of a run in its report.
class Stopwatch {
 public:
  explicit Stopwatch(Report& report) : report_(report) {}

  /// Adds the time since the last lap (or the start) to `stage`.
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
  /// Adds the time since the start to "total", the last entry of the report.
  void total() {
    constexpr std::string_view kTotal = "total";
    last_ = start_;
    lap(kTotal);
    auto& all = report_.seconds;
    const auto total = std::find_if(all.begin(), all.end(), [&](const auto& s) { return s.first == kTotal; });
    std::rotate(total, total + 1, all.end());
  }

 private:
  using Clock = std::chrono::steady_clock;
  Report& report_;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

/// Stages of work on one thread that can be interrupted between them.
class Stages {
 public:
  explicit Stages(Report& report) : watch_(report) {}

  /// Adds the time of a stage. Throws Error(interrupted) if an interrupt was requested.
  void finish(std::string_view stage) {
    watch_.lap(stage);
    Interruptible::check();
  }
  /// Adds the time of all stages to the total.
  void end() { watch_.total(); }

 private:
  Stopwatch watch_;
};

}  // namespace boxunion

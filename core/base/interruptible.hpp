#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <utility>

#include "boxunion/error.hpp"

namespace boxunion {

/// While it exists, work on its thread, and parallel work that this thread starts, ends with
/// Error(interrupted) soon after a flag has become true. Long work on one thread must call check() now and
/// then.
class Interruptible {
 public:
  /// `flag` may be null.
  explicit Interruptible(const std::atomic<bool>* flag) : outer_(std::exchange(flag_, flag)) {}
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  ~Interruptible() { flag_ = outer_; }

  /// The flag of the innermost object on this thread, or null.
  static const std::atomic<bool>* flag() { return flag_; }
  /// Throws Error(interrupted) if that flag is true.
  static void check() {
    if (flag_ && *flag_) throw Error(ErrorKind::interrupted, "interrupted");
  }

 private:
  static inline thread_local const std::atomic<bool>* flag_ = nullptr;
  const std::atomic<bool>* outer_;
};

/// Calls f(i) for 0 <= i < n on this thread, with a check() now and then.
template <class F>
void interruptible_loop(std::size_t n, F&& f) {
  constexpr std::size_t kAtOnce = 1 << 16;
  for (std::size_t begin = 0; begin < n; begin += kAtOnce) {
    Interruptible::check();
    for (std::size_t i = begin, end = std::min(begin + kAtOnce, n); i < end; ++i) f(i);
  }
}

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <cstddef>

#include "core/base/parallel.hpp"

namespace boxunion {

/// Calls f(i) for 0 <= i < n on this thread. Can be interrupted like parallel work: see Interruptible.
template <class F>
void interruptible_loop(std::size_t n, F&& f) {
  constexpr std::size_t kAtOnce = 1 << 16;
  for (std::size_t begin = 0; begin < n; begin += kAtOnce) {
    Interruptible::check();
    for (std::size_t i = begin, end = std::min(begin + kAtOnce, n); i < end; ++i) f(i);
  }
}

}  // namespace boxunion

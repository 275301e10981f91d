#pragma once

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <string>

#include "boxunion/error.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {

/// Runs f on `threads` threads (0: one per core; a negative number throws Error(usage)) and returns its
/// result. Its parallel work ends with Error(interrupted) soon after `interrupted`, if not null, has become
/// true.
template <class F>
auto with_threads(int threads, const std::atomic<bool>* interrupted, F&& f) {
  const auto work = [&] {
    const Interruptible scope(interrupted);
    return f();
  };
  if (threads < 0)
    throw Error(ErrorKind::usage,
                "threads are " + std::to_string(threads) + ", expected 0 (one per core) or more");
  if (threads == 0) return work();
  tbb::task_arena arena(std::min(threads, tbb::info::default_concurrency()));
  return arena.execute(work);
}

}  // namespace boxunion

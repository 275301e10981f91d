#pragma once

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <string>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/base/interruptible.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {

/// Runs f on Options::threads threads (a negative number throws Error(usage)) and returns its result. This is
/// where Options::interrupted takes effect: it becomes the flag that Interruptible watches within f. If it is
/// null, f watches the caller's flag.
template <class F>
auto with_threads(const Options& options, F&& f) {
  const auto work = [&f, flag = options.interrupted ? options.interrupted : Interruptible::flag()] {
    const Interruptible scope(flag);
    return f();
  };
  if (options.threads < 0)
    throw Error(ErrorKind::usage,
                "threads are " + std::to_string(options.threads) + ", expected 0 (one per core) or more");
  if (options.threads == 0) return work();
  tbb::task_arena arena(std::min(options.threads, tbb::info::default_concurrency()));
  return arena.execute(work);
}

}  // namespace boxunion

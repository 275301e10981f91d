#pragma once

#include <tbb/task_arena.h>

#include "host/command.hpp"

namespace boxunion::command {

/// Runs f on as many threads as asked for, and returns what it returns.
template <class F>
auto with_threads(const Common& common, F&& f) {
  tbb::task_arena arena(common.engine.threads > 0 ? common.engine.threads : tbb::task_arena::automatic);
  return arena.execute(f);
}

}  // namespace boxunion::command

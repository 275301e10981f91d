#pragma once

#include <tbb/task_arena.h>

#include <vector>

#include "host/command.hpp"
#include "host/command_output.hpp"
#include "host/engine.hpp"

// What the subcommands that run the engine have in common.

namespace boxunion::command {

/// Runs f on as many threads as asked for, and returns what it returns.
template <class F>
auto with_threads(const Common& common, F&& f) {
  tbb::task_arena arena(common.engine.threads > 0 ? common.engine.threads : tbb::task_arena::automatic);
  return arena.execute(f);
}

/// The options of a run; they refer to `common` and `bar`.
Options engine_options(const Common& common, ProgressBar& bar);

/// Adds method, kernel, device and seconds.
void add_report(std::vector<Result>& results, const Report& report);

}  // namespace boxunion::command

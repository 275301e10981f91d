#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bench/table.hpp"

namespace boxunion {

/// The arguments of a benchmark.
struct Request {
  int runs = 5;                       ///< runs whose median counts
  std::vector<std::size_t> counts;    ///< numbers of boxes to measure
  std::vector<std::string> sections;  ///< sections of the benchmark to run
};

/// The main function of a benchmark: `[RUNS] [COUNT...] [SECTION...] [--json FILE]`. Counts and sections are
/// accepted if the defaults have some. Returns the exit status, which is 1 after an exception, whose message
/// is printed.
int run_benchmark(int argc, char** argv, const std::string& description, Request defaults,
                  const std::function<void(const Request&, Tables&)>& run);

}  // namespace boxunion

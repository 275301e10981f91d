#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bench/table.hpp"

namespace boxunion {

/// What a benchmark is asked for.
struct Request {
  int runs = 5;                       ///< of which the median counts
  std::vector<std::size_t> counts;    ///< of boxes: the sizes to measure
  std::vector<std::string> sections;  ///< of the benchmark: those to measure
};

/// The main function of a benchmark: `[RUNS] [COUNT...] [SECTION...] [--json FILE]`, counts and sections
/// where the defaults have some. Returns the exit status: 1 after an exception, of which the message is
/// printed.
int run_benchmark(int argc, char** argv, const std::string& description, Request defaults,
                  const std::function<void(const Request&, Tables&)>& run);

}  // namespace boxunion

#pragma once

#include <cstdio>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "bench/timing.hpp"

// One side of a comparison is a program of its own. It reads its input, says what it is with a line of JSON
// ({"version": ...}), and then computes once for every line on its standard input and answers each with a
// line: {"seconds": ..., "answer": {...}} or {"error": "..."}. So bench/peers/run has all sides compute in
// turn, each in a process that is warm, and stops one that takes too long.

namespace boxunion::peers {

inline void say(const nlohmann::json& line) {
  std::cout << line << std::endl;
}

/// Answers every line: compute() is timed, describe(result) tells volume, area and counts of what it found.
template <class Compute, class Describe>
void contend(const std::string& version, Compute&& compute, Describe&& describe) {
  say({{"version", version}});
  for (std::string line; std::getline(std::cin, line);) try {
      decltype(compute()) result;
      const double seconds = seconds_of([&] { result = compute(); });
      const nlohmann::json answer = describe(result);
      say({{"seconds", seconds}, {"answer", answer}});
    } catch (const std::exception& e) {
      say({{"error", e.what()}});
    }
}

}  // namespace boxunion::peers

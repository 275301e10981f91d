#pragma once

#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/timing.hpp"

// A side of a comparison is a program. It reads its input and prints a line of JSON that says what it is
// ({"version": ...}). Each line on its standard input is a turn: it computes repeatedly for a quarter of a
// second, at least once, and answers with a line: {"seconds": median, "answer": {...}} or {"error": "..."}.
// bench/peers/run thus lets all sides compute in turn, each with its caches and threads warm, and stops a
// side that takes too long.

namespace boxunion::peers {

inline void say(const nlohmann::json& line) {
  std::cout << line << std::endl;
}

/// Answers every line. compute() is timed. describe(result) returns volume, area and counts of the result.
template <class Compute, class Describe>
void contend(const std::string& version, Compute&& compute, Describe&& describe) {
  say({{"version", version}});
  for (std::string line; std::getline(std::cin, line);) try {
      std::unique_ptr<decltype(compute())> result;
      std::vector<double> seconds;
      for (double turn = 0; turn < kTurn; turn += seconds.back()) {
        result.reset();
        seconds.push_back(seconds_of([&] { result = std::make_unique<decltype(compute())>(compute()); }));
      }
      const nlohmann::json answer = describe(*result);
      result.reset();  // now, so that it takes no time from the other side
      say({{"seconds", median(std::move(seconds))}, {"answer", answer}});
    } catch (const std::exception& e) {
      say({{"error", e.what()}});
    }
}

}  // namespace boxunion::peers

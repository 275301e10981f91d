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

// One side of a comparison is a program of its own. It reads its input, says what it is with a line of JSON
// ({"version": ...}). Each line on its standard input is a turn: it computes, again and again while a quarter
// of a second is not over, and answers with a line: {"seconds": median, "answer": {...}} or {"error": "..."}.
// So bench/peers/run has all sides compute in turn, each with its caches and threads warm, and stops one that
// takes too long.

namespace boxunion::peers {

inline void say(const nlohmann::json& line) {
  std::cout << line << std::endl;
}

/// Answers every line: compute() is timed, describe(result) tells volume, area and counts of what it found.
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
      result.reset();  // now, so that it does not take the other side's time
      say({{"seconds", median(std::move(seconds))}, {"answer", answer}});
    } catch (const std::exception& e) {
      say({{"error", e.what()}});
    }
}

}  // namespace boxunion::peers

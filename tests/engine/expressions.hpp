#pragma once

#include <fmt/format.h>
#include <rapidcheck.h>

#include <algorithm>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "core/cells/expression.hpp"

namespace boxunion {

/// The value of an expression whose operands are true or false.
template <class IsTrue>
bool evaluate(std::span<const Step> steps, IsTrue&& is_true) {
  using Kind = Step::Kind;
  std::vector<bool> stack;
  for (const Step step : steps) {
    if (step.kind == Kind::operand) {
      stack.push_back(is_true(step.operand));
      continue;
    }
    const bool b = stack.back();
    if (step.kind == Kind::complement) {
      stack.back() = !b;
      continue;
    }
    stack.pop_back();
    const bool a = stack.back();
    stack.back() = step.kind == Kind::intersection           ? a && b
                   : step.kind == Kind::union_of_both        ? a || b
                   : step.kind == Kind::symmetric_difference ? a != b
                   : step.kind == Kind::difference           ? a && !b
                                                             : b && !a;
  }
  return stack.at(0);
}

/// Maximum number of results on the stack at a time.
inline std::size_t stack_depth(std::span<const Step> steps) {
  std::size_t depth = 0, most = 0;
  for (const Step step : steps) {
    if (step.kind == Step::Kind::operand)
      most = std::max(most, ++depth);
    else if (step.kind != Step::Kind::complement)
      --depth;
  }
  return most;
}

/// A random expression over A, B, ... in which each occurs. below(n) returns a random number less than n.
template <class Below>
std::string random_expression(std::uint32_t operands, Below&& below) {
  std::vector<std::string> parts;
  for (std::uint32_t i = 0; i < operands; ++i) parts.emplace_back(1, char('A' + i));
  for (std::uint32_t again = below(3); again > 0; --again)  // some twice
    parts.emplace_back(1, char('A' + below(operands)));
  while (parts.size() > 1) {
    const std::uint32_t at = below(std::uint32_t(parts.size()));
    const std::string part = parts[at];
    parts.erase(parts.begin() + at);
    std::string& other = parts[below(std::uint32_t(parts.size()))];
    constexpr const char* kOperations[] = {" and ", " or ", " xor ", " not "};
    other =
        below(2) ? "(" + other + kOperations[below(4)] + part + ")" : other + kOperations[below(4)] + part;
    if (below(2)) other = "(" + other + ")";
  }
  return parts[0];
}

inline std::string random_expression(std::uint32_t operands, std::mt19937& random) {
  return random_expression(operands, [&](std::uint32_t n) { return std::uint32_t(random() % n); });
}

/// The same for RapidCheck.
inline rc::Gen<std::string> expression_text(std::uint32_t operands) {
  return rc::gen::map(rc::gen::arbitrary<std::uint32_t>(), [=](std::uint32_t seed) {
    std::mt19937 random(seed);
    return random_expression(operands, random);
  });
}

}  // namespace boxunion

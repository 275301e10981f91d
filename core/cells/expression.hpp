#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/expression.hpp"

namespace boxunion {

/// Are these steps the union of their operands?
bool is_union(std::span<const Step> steps);

/// How much of a region an operand fills.
enum class Presence : std::uint8_t { absent, partial, all };

/// What an expression is in a region.
enum class Filling : std::uint8_t { nothing, everything, varies };

/// Simplifies an expression in a region: operands that are absent are false there and those that fill it are
/// true. If the result varies, `result` gets what is left, in terms of partial operands only.
/// `presence` is by operand; `steps` and `result` must not overlap.
Filling simplify(std::span<const Step> steps, std::span<const Presence> presence, std::vector<Step>& result);

}  // namespace boxunion

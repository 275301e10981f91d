#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/expression.hpp"

namespace boxunion {

/// True if these steps are the union of their operands.
bool is_union(std::span<const Step> steps);

/// How much of a region an operand fills.
enum class Presence : std::uint8_t { absent, partial, all };

/// The value of an expression in a region.
enum class Filling : std::uint8_t { nothing, everything, varies };

/// Simplifies an expression in a region. Operands that are absent are false there; operands that fill the
/// region are true. If the result varies, `result` gets the remaining steps, which use partial operands only.
/// `presence` is by operand. `steps` and `result` must not overlap.
Filling simplify(std::span<const Step> steps, std::span<const Presence> presence, std::vector<Step>& result);

}  // namespace boxunion

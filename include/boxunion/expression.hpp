#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

/// One step of a boolean expression in postfix order. An operand is pushed on a stack. An operation takes its
/// arguments from the stack and pushes its result.
struct Step {
  enum class Kind : std::uint8_t {
    operand,               ///< a set of boxes
    complement,            ///< not a; comes from simplify() only
    intersection,          ///< a and b
    union_of_both,         ///< a or b
    symmetric_difference,  ///< a xor b
    difference,            ///< a not b
    reversed_difference    ///< b not a
  };
  Kind kind = Kind::operand;
  std::uint32_t operand = 0;  ///< index of the operand

  friend bool operator==(const Step&, const Step&) = default;
};

/// A boolean expression over sets of boxes, each of which stands for the union of its boxes.
///
///   or         = xor {("or" | "|") xor}
///   xor        = difference {("xor" | "^") difference}
///   difference = operand {("and" | "&" | "not" | "minus" | "-" | "and" "not" | ...) operand}
///   operand    = NAME | "(" or ")"
///
/// "and" and "not" bind tightest, then "xor", then "or". Operations of equal rank go from left to right, so
/// "A and B not C" is what lies in A and in B but not in C. "not" and "minus" stand between two operands,
/// also after "and". There is no complement of a set, because it would have no bounds. Words may be in upper
/// or lower case. A name consists of letters, digits and _, and begins with a letter or _.
class BOXUNION_API Expression {
 public:
  /// The maximum number of intermediate results on the stack. Any expression of fewer than 2^15 operands
  /// needs no more.
  static constexpr std::uint32_t kMostDepth = 16;

  /// Parses a text in time and memory proportional to its length, for any depth of parentheses. Throws
  /// Error(usage) with the column, counted from 1, what was found and what was expected.
  static Expression parse(std::string_view text);
  /// True if a text can be the name of an operand.
  static bool is_name(std::string_view text);
  /// The union of the boxes of one set.
  static Expression one_operand();

  /// The names of the operands, in the order of their first appearance.
  const std::vector<std::string>& names() const { return names_; }
  /// The column where each name first appears, counted from 1.
  const std::vector<std::size_t>& columns() const { return columns_; }
  /// The steps, in an order that keeps the stack low (Sethi and Ullman): of two results, the one that needs
  /// more of the stack comes first.
  std::span<const Step> steps() const { return steps_; }
  /// True if it is the union of its operands.
  bool is_union() const;

 private:
  std::vector<std::string> names_;
  std::vector<std::size_t> columns_;
  std::vector<Step> steps_;
};

}  // namespace boxunion

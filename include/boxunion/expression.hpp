#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

/// One step of a boolean expression in postfix order. An operand goes on a stack; an operation takes what it
/// is about from there and puts its result back.
struct Step {
  enum class Kind : std::uint8_t {
    operand,               ///< a set of boxes
    complement,            ///< not a; parse() gives none, simplify() may
    intersection,          ///< a and b
    union_of_both,         ///< a or b
    symmetric_difference,  ///< a xor b
    difference,            ///< a not b
    reversed_difference    ///< b not a
  };
  Kind kind = Kind::operand;
  std::uint32_t operand = 0;  ///< which one

  friend bool operator==(const Step&, const Step&) = default;
};

/// A boolean expression over sets of boxes, each of which stands for the union of its boxes.
///
///   or         = xor {("or" | "|") xor}
///   xor        = difference {("xor" | "^") difference}
///   difference = operand {("and" | "&" | "not" | "minus" | "-" | "and" "not" | ...) operand}
///   operand    = NAME | "(" or ")"
///
/// "and" and "not" bind tightest, then "xor", then "or"; equal ones from left to right, so "A and B not C" is
/// what lies in A and in B but not in C. "not" and "minus" stand between two operands, also behind "and";
/// there is no complement of a set, which would have no bounds. Words are read in any case. A name has
/// letters, digits and _, and begins with a letter or _.
class BOXUNION_API Expression {
 public:
  /// Operations wait for each other on a stack of at most so many results; so many that any expression of
  /// fewer than 2^15 operands fits.
  static constexpr std::uint32_t kMostDepth = 16;

  /// Takes time and memory in proportion to the text, however deep its parentheses. Throws Error(usage) that
  /// names the column, counted from 1, what is there and what was expected.
  static Expression parse(std::string_view text);
  /// May it be the name of an operand?
  static bool is_name(std::string_view text);
  /// The union of the boxes of one set.
  static Expression one_operand();

  /// Of the operands, in order of their first appearance.
  const std::vector<std::string>& names() const { return names_; }
  /// Where each name first appears, counted from 1.
  const std::vector<std::size_t>& columns() const { return columns_; }
  /// In an order that keeps the stack low (Sethi and Ullman): of two results the one that needs more of it
  /// comes first.
  std::span<const Step> steps() const { return steps_; }
  /// Is it the union of its operands?
  bool is_union() const;

 private:
  std::vector<std::string> names_;
  std::vector<std::size_t> columns_;
  std::vector<Step> steps_;
};

}  // namespace boxunion

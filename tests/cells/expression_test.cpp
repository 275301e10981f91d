#include "core/cells/expression.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <numeric>

#include "boxunion/error.hpp"
#include "tests/engine/expressions.hpp"

namespace boxunion {

void PrintTo(const Step& step, std::ostream* out) {
  *out << int(step.kind) << ':' << step.operand;
}

namespace {

/// The value of an expression for every subset of up to 5 operands that are true, one bit for each subset.
/// Operands are identified by name: A is bit 0.
std::uint32_t truth_table(std::string_view text) {
  const Expression expression = Expression::parse(text);
  std::uint32_t table = 0;
  for (std::uint32_t subset = 0; subset < 32; ++subset) {
    const auto is_true = [&](std::uint32_t operand) {
      return (subset >> (expression.names()[operand].at(0) - 'A') & 1u) != 0;
    };
    table |= std::uint32_t(evaluate(expression.steps(), is_true)) << subset;
  }
  return table;
}

constexpr std::uint32_t A = 0xaaaaaaaau, B = 0xccccccccu, C = 0xf0f0f0f0u, D = 0xff00ff00u;

TEST(Expression, OperationsMeanWhatSetTheorySays) {
  EXPECT_EQ(truth_table("A"), A);
  for (const char* text : {"A and B", "A & B", "A AND B", "(A)and(B)", "A&B"})
    EXPECT_EQ(truth_table(text), A & B) << text;
  for (const char* text : {"A or B", "A | B", "A Or B"}) EXPECT_EQ(truth_table(text), A | B) << text;
  for (const char* text : {"A xor B", "A ^ B"}) EXPECT_EQ(truth_table(text), A ^ B) << text;
  for (const char* text : {"A not B", "A minus B", "A - B", "A-B", "A and not B", "A & -B"})
    EXPECT_EQ(truth_table(text), A & ~B) << text;
}

TEST(Expression, AndAndNotBindTighterThanXorAndXorTighterThanOr) {
  EXPECT_EQ(truth_table("A and B not C"), A & B & ~C);
  EXPECT_EQ(truth_table("A and (B or C) not D"), A & (B | C) & ~D);
  EXPECT_EQ(truth_table("A not B and C"), A & ~B & C);
  EXPECT_EQ(truth_table("A not (B and C)"), A & ~(B & C));
  EXPECT_EQ(truth_table("A not (B not (C not D))"), A & ~(B & ~(C & ~D)));
  EXPECT_EQ(truth_table("A not B not C"), A & ~B & ~C);
  EXPECT_EQ(truth_table("A or B and C"), A | (B & C));
  EXPECT_EQ(truth_table("A or B not C"), A | (B & ~C));
  EXPECT_EQ(truth_table("A xor B and C"), A ^ (B & C));
  EXPECT_EQ(truth_table("A or B xor C"), A | (B ^ C));
  EXPECT_EQ(truth_table("A xor B or C"), (A ^ B) | C);
  EXPECT_EQ(truth_table("A and B and not C or D"), (A & B & ~C) | D);
  EXPECT_EQ(truth_table("A not (B and C) xor D"), (A & ~(B & C)) ^ D);
}

TEST(Expression, NamesComeInOrderOfAppearanceAndOnce) {
  const Expression e = Expression::parse("metal_1 and(Via2 not metal_1)or _x");
  EXPECT_EQ(e.names(), (std::vector<std::string>{"metal_1", "Via2", "_x"}));
  EXPECT_EQ(e.columns(), (std::vector<std::size_t>{1, 13, 33}));
}

TEST(Expression, ErrorsNameTheColumn) {
  const auto expect_error = [](std::string_view text, const std::string& message) {
    try {
      Expression::parse(text);
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::usage);
      EXPECT_EQ(error.what(), "expression, column " + message) << text;
    }
  };
  expect_error("", "1: expected a name or '(', found the end");
  expect_error("  ", "3: expected a name or '(', found the end");
  expect_error("A and", "6: expected a name or '(', found the end");
  expect_error("A and or B", "7: expected a name or '(', found 'or'");
  expect_error("A B", "3: expected an operation or ')', found 'B'");
  expect_error("A (B)", "3: expected an operation or ')', found '('");
  expect_error("()", "2: expected a name or '(', found ')'");
  expect_error("(A or (B)", "1: '(' without ')'");
  expect_error("A or B)", "7: ')' without '('");
  expect_error("A + B", "3: unexpected '+'");
  expect_error("A and 2B", "7: '2B' is not a name: a name begins with a letter or _");
  const std::string unary = " needs an operand on its left, such as \"A not B\": a complement has no bounds";
  expect_error("not A", "1: 'not'" + unary);
  expect_error("A or not B", "6: 'not'" + unary);
  expect_error("A and (- B)", "8: '-'" + unary);
  expect_error("A and not not B", "11: 'not'" + unary);
}

TEST(Expression, OfManyOperandsNeedsLittleStack) {
  // an expression nested to the right as deep as possible, and a full binary tree of 1024 operands
  std::string nested, ends;
  for (int i = 0; i < 5000; ++i) nested += fmt::format("A{} not (", i), ends += ")";
  EXPECT_EQ(stack_depth(Expression::parse(nested + "B" + ends).steps()), 2u);
  const auto tree = [](auto&& self, int level, int index) -> std::string {
    if (level == 0) return fmt::format("N{}", index);
    return fmt::format("({} and {})", self(self, level - 1, 2 * index), self(self, level - 1, 2 * index + 1));
  };
  EXPECT_EQ(stack_depth(Expression::parse(tree(tree, 10, 0)).steps()), 11u);
  EXPECT_THROW(Expression::parse(tree(tree, 16, 0)), Error);
}

TEST(Expression, IsAUnionOnlyWithoutOtherOperations) {
  EXPECT_TRUE(Expression::parse("A").is_union());
  EXPECT_TRUE(Expression::parse("A or (B or C)").is_union());
  EXPECT_FALSE(Expression::parse("A or B and C").is_union());
  EXPECT_TRUE(Expression::one_operand().is_union());
}

RC_GTEST_PROP(Expression, SimplificationKeepsTheFunction, ()) {
  const auto operands = *rc::gen::inRange<std::uint32_t>(1, 7);
  const Expression expression = Expression::parse(*expression_text(operands));
  const auto used = std::uint32_t(expression.names().size());
  std::vector<Presence> presence;
  for (std::uint32_t i = 0; i < used; ++i)
    presence.push_back(*rc::gen::element(Presence::absent, Presence::partial, Presence::all));
  std::vector<Step> rest;
  const Filling filling = simplify(expression.steps(), presence, rest);
  RC_ASSERT(stack_depth(rest) <= stack_depth(expression.steps()));
  for (const Step step : rest)
    RC_ASSERT(step.kind != Step::Kind::operand || presence[step.operand] == Presence::partial);
  for (std::uint32_t subset = 0; subset < 1u << used; ++subset) {
    const auto is_true = [&](std::uint32_t i) {
      return presence[i] == Presence::partial ? (subset >> i & 1u) != 0 : presence[i] == Presence::all;
    };
    const bool expected = evaluate(expression.steps(), is_true);
    RC_ASSERT(expected ==
              (filling == Filling::varies ? evaluate(rest, is_true) : filling == Filling::everything));
  }
  // the remaining expression may be simplified again
  std::vector<Step> nothing;
  std::ranges::fill(presence, Presence::absent);
  if (filling == Filling::varies)
    RC_ASSERT((simplify(rest, presence, nothing) == Filling::everything) ==
              evaluate(rest, [](std::uint32_t) { return false; }));
}

}  // namespace
}  // namespace boxunion

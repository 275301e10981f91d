// Any text as a boolean expression: rejected with an Error, or the same function before and after simplify().

#include "core/cells/expression.hpp"

#include <cstdint>
#include <string_view>

#include "boxunion/error.hpp"
#include "tests/engine/expressions.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace boxunion::fuzz {
namespace {

void check(const Expression& expression) {
  const std::size_t count = expression.names().size();
  expect(count > 0 && expression.columns().size() == count);
  for (const std::string& name : expression.names()) expect(Expression::is_name(name));
  expect(stack_depth(expression.steps()) <= Expression::kMostDepth);

  // In round 0 all operands vary, so nothing may change. In later rounds some are constant.
  std::vector<Presence> presence(count, Presence::partial);
  std::vector<Step> rest;
  std::uint32_t random = 1;
  const auto next = [&] { return (random = random * 1664525 + 1013904223) >> 16; };
  for (int round = 0; round < 8; ++round) {
    const Filling filling = simplify(expression.steps(), presence, rest);
    if (round == 0) expect(filling == Filling::varies && std::ranges::equal(rest, expression.steps()));
    for (int subset = 0; subset < 16; ++subset) {
      std::vector<bool> is_in(count);
      for (std::size_t i = 0; i < count; ++i)
        is_in[i] = presence[i] == Presence::partial ? next() % 2 == 1 : presence[i] == Presence::all;
      const auto is_true = [&](std::uint32_t i) { return bool(is_in[i]); };
      expect(evaluate(expression.steps(), is_true) ==
             (filling == Filling::varies ? evaluate(rest, is_true) : filling == Filling::everything));
    }
    for (Presence& p : presence) p = Presence(next() % 3);
  }
}

}  // namespace
}  // namespace boxunion::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace boxunion;
  try {
    fuzz::check(Expression::parse({reinterpret_cast<const char*>(bytes), count}));
  } catch (const Error& error) {
    fuzz::expect(error.kind() == ErrorKind::usage);
  }
  return 0;
}

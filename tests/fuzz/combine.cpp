// A boolean expression and sets of boxes from any bytes: cells give the same result as a sweep of sections.

#include <cstdint>

#include "core/solid/mass_sink.hpp"
#include "tests/engine/expressions.hpp"
#include "tests/engine/sweep.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace boxunion::fuzz {
namespace {

void check(const Expression& expression, const std::vector<BoxSet>& sets, const AxisOrder& order,
           const Tuning& tuning) {
  const Solid found = combine(expression, sets, native());
  expect(sweep(expression, sets, found.axes, order).vertices == make_evm(found, order).vertices);
  MassSink sink(found.axes);
  sink.add(found.vertices);
  Options options = native();
  options.tuning = tuning;
  expect(combine(expression, sets, options).vertices == found.vertices);
  expect(measure(expression, sets, options) == sink.result());
}

}  // namespace
}  // namespace boxunion::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace boxunion;
  fuzz::Bytes input(bytes, count);
  const auto below = [&](std::uint32_t limit) { return std::uint32_t(input.below(int(limit))); };
  const Expression expression = Expression::parse(random_expression(1 + below(5), below));
  const AxisOrder order = input.one_of(kAxisOrders);
  const Tuning tuning =
      input.one_of(std::array{Tuning{}, Tuning{.cell = 1}, Tuning{.cell = 4}, Tuning{.cell_boxes = 1}});
  const int range = 1 + input.below(20);
  std::vector<BoxSet> sets;
  for (std::size_t i = 0; i < expression.names().size(); ++i)
    sets.push_back(fuzz::take_box_set(input, 12, range));
  fuzz::check(expression, sets, order, tuning);
  return 0;
}

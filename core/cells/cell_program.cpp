#include "core/cells/cell_program.hpp"

namespace boxunion {

static_assert(Expression::kMostDepth <= PROGRAM_RESULTS, "a program's results fit the kernels' stack");

CellProgram append_program(std::span<const Step> steps, std::span<const CellBoxes> boxes,
                           std::vector<CellStep>& out) {
  using Kind = Step::Kind;
  using Operation = CellStep::Operation;
  const std::size_t first = out.size();
  const auto add = [&](Operation operation) { out.push_back({operation, {}}); };
  // An operation whose second result has just been made from boxes takes these boxes itself.
  const auto add_or_take_boxes = [&](Operation operation, Operation with_boxes) {
    if (out.size() > first + 1 && out.back().operation == Operation::push)
      out.back().operation = with_boxes;
    else
      add(operation);
  };
  for (const Step step : steps) {
    switch (step.kind) {
      case Kind::operand:
        out.push_back({Operation::push, boxes[step.operand]});
        break;
      case Kind::complement:
        add(Operation::complement);
        break;
      case Kind::intersection:
        add(Operation::intersection);
        break;
      case Kind::union_of_both:
        add_or_take_boxes(Operation::union_of_both, Operation::unite);
        break;
      case Kind::symmetric_difference:
        add(Operation::symmetric_difference);
        break;
      case Kind::difference:
        add_or_take_boxes(Operation::difference, Operation::carve);
        break;
      case Kind::reversed_difference:
        add(Operation::reversed_difference);
        break;
    }
  }
  return {std::uint32_t(first), std::uint32_t(out.size() - first)};
}

}  // namespace boxunion

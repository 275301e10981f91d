#pragma once

#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "boxunion/union.hpp"
#include "core/cells/expression.hpp"
#include "core/models/sections.hpp"

namespace boxunion {

/// The vertices of a solid on other axes, which must have all of its coordinates.
inline Evm evm_in(const Axes& axes, Solid solid, const AxisOrder& order) {
  for (Vertex& v : solid.vertices) {
    v.x = axes[0].ordinal(solid.axes[0].coordinate(v.x));
    v.y = axes[1].ordinal(solid.axes[1].coordinate(v.y));
    v.z = axes[2].ordinal(solid.axes[2].coordinate(v.z));
  }
  solid.axes = axes;
  return make_evm(solid, order);
}

/// Evaluates an expression by sweeping sections, operation by operation.
inline Evm sweep(const Expression& expression, std::span<const BoxSet> sets, const Axes& axes,
                 const AxisOrder& order) {
  std::vector<Evm> stack;
  for (const Step& step : expression.steps()) {
    if (step.kind == Step::Kind::operand) {
      stack.push_back(evm_in(axes, unite(sets[step.operand], {.device = "native"}), order));
      continue;
    }
    const Evm b = std::move(stack.back());
    stack.pop_back();
    const Evm a = std::move(stack.back());
    stack.pop_back();
    switch (step.kind) {
      case Step::Kind::intersection:
        stack.push_back(combine(a, b, BooleanOperation::intersect));
        break;
      case Step::Kind::union_of_both:
        stack.push_back(combine(a, b, BooleanOperation::unite));
        break;
      case Step::Kind::symmetric_difference:
        stack.push_back(combine(a, b, BooleanOperation::exclude));
        break;
      case Step::Kind::difference:
        stack.push_back(combine(a, b, BooleanOperation::subtract));
        break;
      case Step::Kind::reversed_difference:
        stack.push_back(combine(b, a, BooleanOperation::subtract));
        break;
      case Step::Kind::operand:
      case Step::Kind::complement:
        throw std::logic_error("no expression has complements, and operands were pushed above");
    }
  }
  return stack.at(0);
}

}  // namespace boxunion

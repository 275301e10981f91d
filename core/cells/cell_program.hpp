#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/cells/expression.hpp"
#include "kernels/contract.h"

namespace boxunion {

/// The boxes of a cell that belong to an operand, counted from the cell's first box.
struct CellBoxes {
  std::uint32_t first = 0, count = 0;
};

/// One operation of a cell's program, in the form that kernels read: an expression over the cell's boxes, in
/// postfix order. Boxes that are united with the last result, or taken out of it, need no result of their
/// own.
struct CellStep {
  enum class Operation : std::uint32_t {
    push = STEP_PUSH,    ///< a new result: the union of some boxes
    unite = STEP_UNITE,  ///< the last result and some boxes
    carve = STEP_CARVE,  ///< the last result without some boxes
    complement = STEP_COMPLEMENT,
    intersection = STEP_INTERSECTION,
    union_of_both = STEP_UNION,
    symmetric_difference = STEP_SYMMETRIC_DIFFERENCE,
    difference = STEP_DIFFERENCE,
    reversed_difference = STEP_REVERSED_DIFFERENCE
  };
  Operation operation = Operation::push;
  CellBoxes boxes;  ///< for push, unite and carve
};

/// A cell's program. Without steps, the cell is the union of its boxes.
struct CellProgram {
  std::uint32_t first = 0, count = 0;  ///< in CellBatch::steps
};

/// Appends an expression's program to `out`. `boxes` is by operand.
CellProgram append_program(std::span<const Step> steps, std::span<const CellBoxes> boxes,
                           std::vector<CellStep>& out);

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "boxunion/axis.hpp"
#include "boxunion/box.hpp"
#include "boxunion/evm.hpp"
#include "boxunion/export.hpp"

namespace boxunion {

/// How a solid is cut into disjoint boxes (Cruz-Matías and Ayala, sections 2.2 and 3).
enum class BoxModel {
  oudb,  ///< Ordered Union of Disjoint Boxes: cut at every plane of vertices, and each slice at every line of
         ///< vertices
  cudb   ///< Compact Union of Disjoint Boxes: the OUDB with equal neighbors along B merged, then along A
};

/// Disjoint boxes whose union is a solid.
struct Decomposition {
  Axes axes;  ///< of x, y and z
  AxisOrder order = kAxisOrders[0];
  std::vector<OrdinalBox> boxes;  ///< corners in the order A, B, C; sorted by their low corners
};

// These functions throw Error(usage) for an order that has an axis twice.

/// The decomposition of a solid, in the order of its EVM. No two boxes touch along C. Throws Error(resources)
/// if memory does not suffice or there are 2^32 boxes or more.
///
/// Both models take near-linear time and memory in the vertices of the solid and the boxes. CUDB is made
/// without the OUDB. It looks only at rectangles of a section that touch what a plane of vertices flips.
BOXUNION_API Decomposition decompose(const Evm& evm, BoxModel model);

/// The number of boxes that decompose() would give, or most + 1 if there are more than `most`. Does not find
/// all of them in that case.
BOXUNION_API std::uint64_t count_boxes(const Evm& evm, BoxModel model,
                                       std::uint64_t most = std::uint64_t{1} << 62);

/// The extreme vertices of a solid in the first order that gives the model the fewest boxes. One order may
/// give far more boxes than another, so no count goes much beyond the best one.
BOXUNION_API Evm make_evm_of_fewest_boxes(const Solid& solid, BoxModel model);

/// The extreme vertices of the union of disjoint boxes: their symmetric difference (section 3.3).
BOXUNION_API Evm make_evm(const Decomposition& decomposition);

/// True if all axes are lattices of integers that fit 32 bits.
BOXUNION_API bool hold_int32(const Axes& axes);

/// The boxes with coordinates in the order x, y, z. They are integers if the axes hold_int32, otherwise
/// doubles.
BOXUNION_API BoxSet to_boxes(const Decomposition& decomposition);

}  // namespace boxunion

#pragma once

#include <cstddef>
#include <span>

#include "boxunion/box.hpp"

// Families of boxes that look ordinary but are hard on some part of the work: many tiles, deep overlap, long
// and thin boxes, many equal or many distinct coordinates. Tests, the soak and bench/families share them.

namespace boxunion {

/// A rule that makes any number of boxes, the same on every machine.
struct Family {
  const char* name;
  const char* what;  ///< a line that describes the boxes
  /// Makes about `size` boxes. If the union of a family has far more vertices than boxes, it makes boxes with
  /// about `size` vertices.
  BoxSet (*make)(std::size_t size);
};

std::span<const Family> families();

/// The order of rows; no result depends on it.
enum class RowOrder { given, reversed, shuffled };
inline constexpr RowOrder kRowOrders[] = {RowOrder::given, RowOrder::reversed, RowOrder::shuffled};
const char* name(RowOrder order);

/// The boxes in another order.
BoxSet reorder(const BoxSet& boxes, RowOrder order);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/axis.hpp"
#include "boxunion/export.hpp"
#include "boxunion/solid.hpp"

namespace boxunion {

/// An order ABC of the axes (0 x, 1 y, 2 z). Models are sorted by A, then B, then C. They sweep a plane along
/// A, and in it a line along B.
using AxisOrder = std::array<std::uint8_t, 3>;

inline constexpr std::array<AxisOrder, 6> kAxisOrders = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// Throws Error(usage) unless each axis occurs once.
BOXUNION_API void validate(const AxisOrder& order);
/// "xyz", "xzy", ...
BOXUNION_API std::string to_string(const AxisOrder& order);
/// The order with such a name, if there is one.
BOXUNION_API std::optional<AxisOrder> axis_order(std::string_view name);

/// A point on the last D axes of an order. Points sort lexicographically. Coordinates are ordinals. If a
/// solid has no axes for all of its parts, they are any unsigned numbers that sort like the coordinates, for
/// example ordered_bits.
template <std::size_t D, class C = std::uint32_t>
using OrderedPoint = std::array<C, D>;

/// The sorted extreme vertices of a solid in D dimensions: a complete model of it (Aguilera, "Orthogonal
/// Polyhedra: Study and Application", 1998).
template <std::size_t D, class C = std::uint32_t>
using ExtremeVertices = std::vector<OrderedPoint<D, C>>;

/// The extreme vertices model of a solid (Cruz-Matías and Ayala, CUDB, section 2.1): the vertices with an odd
/// octant mask, sorted by A, B, C.
struct Evm {
  Axes axes;  ///< of x, y and z
  AxisOrder order = kAxisOrders[0];
  ExtremeVertices<3> vertices;  ///< ordinals in the order A, B, C

  /// The x, y, z of a vertex.
  std::array<double, 3> coordinates(std::size_t i) const {
    std::array<double, 3> point{};
    for (std::size_t k = 0; k < 3; ++k) point[order[k]] = axes[order[k]].coordinate(vertices[i][k]);
    return point;
  }
};

// These functions throw Error(usage) for an order that has an axis twice.

/// The extreme vertices of a solid.
BOXUNION_API Evm make_evm(const Solid& solid, const AxisOrder& order);
/// The same model in another order.
BOXUNION_API Evm reorder(const Evm& evm, const AxisOrder& order);
/// All vertices of the solid with their octant masks; those that are not extreme are found again. Takes time
/// in proportion to the sum of the sizes of all sections along z.
BOXUNION_API Solid make_solid(const Evm& evm);

/// Regularised boolean operations. Bit p + 2q is the result for operands p and q.
enum class BooleanOperation : std::uint8_t {
  intersect = 0b1000,
  unite = 0b1110,
  subtract = 0b0010,
  exclude = 0b0110  ///< symmetric difference
};

/// The operation on two solids with the same axes and order (otherwise Error(usage)), by a sweep over their
/// sections, recursively down to intervals of a line. Takes time in proportion to the sum of the sizes of all
/// sections.
BOXUNION_API Evm combine(const Evm& p, const Evm& q, BooleanOperation operation);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/boxes/axis.hpp"
#include "core/solid/solid.hpp"

namespace boxunion {

/// An order ABC of the axes (0 x, 1 y, 2 z): models sort by A, then B, then C, and sweep a plane along A and
/// in it a line along B.
using AxisOrder = std::array<std::uint8_t, 3>;

inline constexpr std::array<AxisOrder, 6> kAxisOrders = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// Throws Error(usage) unless each axis is there once.
void validate(const AxisOrder& order);
/// "xyz", "xzy", ...
std::string to_string(const AxisOrder& order);
/// The order of such a name, if it is one.
std::optional<AxisOrder> axis_order(std::string_view name);

/// A point on the last D axes of an order; points sort lexicographically. In ordinals, or where there are no
/// axes for all of a solid in any unsigned numbers that sort as the coordinates do, for example ordered_bits.
template <std::size_t D, class C = std::uint32_t>
using OrderedPoint = std::array<C, D>;

/// A number that sorts as the point does.
struct PointKey {
  std::uint32_t operator()(const OrderedPoint<1>& p) const { return p[0]; }
  std::uint64_t operator()(const OrderedPoint<2>& p) const { return std::uint64_t(p[0]) << 32 | p[1]; }
  unsigned __int128 operator()(const OrderedPoint<3>& p) const {
    return static_cast<unsigned __int128>(p[0]) << 64 | (std::uint64_t(p[1]) << 32 | p[2]);
  }
  std::uint64_t operator()(const OrderedPoint<1, std::uint64_t>& p) const { return p[0]; }
  unsigned __int128 operator()(const OrderedPoint<2, std::uint64_t>& p) const {
    return static_cast<unsigned __int128>(p[0]) << 64 | p[1];
  }
};

/// The extreme vertices of a solid in D dimensions, sorted: a complete model of it (Aguilera, "Orthogonal
/// Polyhedra: Study and Application", 1998).
template <std::size_t D, class C = std::uint32_t>
using ExtremeVertices = std::vector<OrderedPoint<D, C>>;

/// The extreme vertices model of a solid (Cruz-Matías and Ayala, CUDB, section 2.1): the vertices with an odd
/// octant mask, ABC-sorted.
struct Evm {
  Axes axes;  ///< of x, y and z
  AxisOrder order = kAxisOrders[0];
  ExtremeVertices<3> vertices;  ///< ordinals in the order A, B, C

  /// x, y, z of a vertex.
  std::array<double, 3> coordinates(std::size_t i) const {
    std::array<double, 3> point{};
    for (std::size_t k = 0; k < 3; ++k) point[order[k]] = axes[order[k]].coordinate(vertices[i][k]);
    return point;
  }
};

// These throw Error(usage) for an order that has an axis twice.

/// The extreme vertices of a solid.
Evm make_evm(const Solid& solid, const AxisOrder& order);
/// The same model in another order.
Evm reorder(const Evm& evm, const AxisOrder& order);
/// All vertices of the solid with their octant masks: those that are not extreme are found again. Costs about
/// the sum of the sizes of all sections along z.
Solid make_solid(const Evm& evm);

/// Regularised symmetric difference of two solids: the extreme vertices that are in one of both.
template <std::size_t D, class C>
void exclusive_or(const std::vector<std::array<C, D>>& p, const std::vector<std::array<C, D>>& q,
                  std::vector<std::array<C, D>>& result);

/// Walks through the slices of a solid along its first axis. Section i, the (D-1)-dimensional cut through
/// slice i, is the symmetric difference of section i - 1 and of the plane of vertices between them (section
/// 2.1, equation 1).
template <std::size_t D, class C = std::uint32_t>
class SectionSweep {
 public:
  static constexpr C kEnd = std::numeric_limits<C>::max();  ///< above every coordinate

  /// Before the first plane; `vertices` must stay.
  explicit SectionSweep(std::span<const OrderedPoint<D, C>> vertices) : rest_(vertices) {}

  /// Where the next plane of vertices is; kEnd behind the last.
  C next() const { return rest_.empty() ? kEnd : rest_.front()[0]; }
  /// Passes the next plane.
  void advance();

  /// The plane passed last, projected.
  const ExtremeVertices<D - 1, C>& plane() const { return plane_; }
  /// The section behind it.
  const ExtremeVertices<D - 1, C>& section() const { return section_; }

 private:
  std::span<const OrderedPoint<D, C>> rest_;
  ExtremeVertices<D - 1, C> plane_, section_, scratch_;
};

/// Regularised boolean operations; bit p + 2q is the result where the operands are p and q.
enum class BooleanOperation : std::uint8_t {
  intersect = 0b1000,
  unite = 0b1110,
  subtract = 0b0010,
  exclude = 0b0110  ///< symmetric difference
};

/// The operation on two solids with the same axes and order (else it throws Error(usage)), by sweeping their
/// sections: recursively down to intervals of a line. Costs about the sum of the sizes of all their sections.
Evm combine(const Evm& p, const Evm& q, BooleanOperation operation);

}  // namespace boxunion

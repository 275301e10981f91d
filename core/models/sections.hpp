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

#include "boxunion/evm.hpp"

namespace boxunion {

/// A number that sorts like the point.
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

/// The regularised symmetric difference of two solids: the extreme vertices of exactly one of them.
template <std::size_t D, class C>
void exclusive_or(const std::vector<std::array<C, D>>& p, const std::vector<std::array<C, D>>& q,
                  std::vector<std::array<C, D>>& result);

/// Sweeps over the slices of a solid along its first axis. Section i, the (D-1)-dimensional cut through slice
/// i, is the symmetric difference of section i - 1 and the plane of vertices between them (section 2.1,
/// equation 1).
template <std::size_t D, class C = std::uint32_t>
class SectionSweep {
 public:
  static constexpr C kEnd = std::numeric_limits<C>::max();  ///< above every coordinate

  /// Starts before the first plane. `vertices` must outlive the sweep.
  explicit SectionSweep(std::span<const OrderedPoint<D, C>> vertices) : rest_(vertices) {}

  /// The coordinate of the next plane of vertices; kEnd after the last one.
  C next() const { return rest_.empty() ? kEnd : rest_.front()[0]; }
  /// Passes the next plane.
  void advance();

  /// The last plane passed, without its first coordinate.
  const ExtremeVertices<D - 1, C>& plane() const { return plane_; }
  /// The section after that plane.
  const ExtremeVertices<D - 1, C>& section() const { return section_; }

 private:
  std::span<const OrderedPoint<D, C>> rest_;
  ExtremeVertices<D - 1, C> plane_, section_, scratch_;
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace boxunion {

/// Three coordinates of 20 bits in one word, each below a guard bit, so that one subtraction compares all
/// three axes at once (kernels/cell_occupancy.k has the device's side).
namespace packed {

inline constexpr int kBits = 20;  ///< of a coordinate
inline constexpr std::uint32_t kMax = (1u << kBits) - 1;
inline constexpr std::uint64_t kGuards =
    std::uint64_t{1} << 20 | std::uint64_t{1} << 41 | std::uint64_t{1} << 62;

constexpr std::uint64_t pack(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return x | std::uint64_t{y} << 21 | std::uint64_t{z} << 42;
}
constexpr std::uint32_t field(std::uint64_t p, int axis) {
  return std::uint32_t(p >> (21 * axis)) & kMax;
}
/// The bit above a coordinate.
constexpr std::uint64_t guard(int axis) {
  return std::uint64_t{1} << (21 * axis + kBits);
}
/// Replaces one coordinate.
constexpr std::uint64_t with_field(std::uint64_t p, int axis, std::uint32_t value) {
  return (p & ~(std::uint64_t{kMax} << (21 * axis))) | std::uint64_t{value} << (21 * axis);
}
/// a <= b on every axis?
constexpr bool all_le(std::uint64_t a, std::uint64_t b) {
  return (((b | kGuards) - a) & kGuards) == kGuards;
}

}  // namespace packed

/// A box of a tile: packed coordinates that count from 1 at the tile's low corner; 0 stands for everything
/// below the tile and size + 1 for its upper end and beyond.
struct PackedBox {
  std::uint64_t lo = 0, hi = 0;
  friend bool operator==(const PackedBox&, const PackedBox&) = default;
  friend auto operator<=>(const PackedBox&, const PackedBox&) = default;
};

/// A region [lo, hi) of a tile, packed like its boxes.
///
/// It owns the points lo <= p < hi on every axis. The boxes that touch it decide all about those points; one
/// that covers it leaves no vertex there.
struct PackedRegion {
  std::uint64_t lo = 0, hi = 0;

  bool touched_by(const PackedBox& box) const {
    return packed::all_le(lo, box.hi) && packed::all_le(box.lo, hi - packed::pack(1, 1, 1));
  }
  bool covered_by(const PackedBox& box) const {
    return packed::all_le(box.lo, lo - packed::pack(1, 1, 1)) && packed::all_le(hi, box.hi);
  }
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "kernels/contract.h"

namespace boxunion {

/// Three coordinates of 20 bits in one word, each below a guard bit, so that one subtraction compares all
/// three axes at once (kernels/cell.h has the device's side).
namespace packed {

inline constexpr int kBits = PACKED_BITS;      ///< bits of a coordinate
inline constexpr int kStride = PACKED_STRIDE;  ///< from one coordinate to the next
inline constexpr std::uint32_t kMax = PACKED_MOST;
inline constexpr std::uint64_t kGuards = std::uint64_t{PACKED_GUARDS_HIGH} << 32 | PACKED_GUARDS_LOW;

constexpr std::uint64_t pack(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return x | std::uint64_t{y} << kStride | std::uint64_t{z} << (2 * kStride);
}
inline constexpr std::uint64_t kOnes = pack(1, 1, 1);
constexpr std::uint32_t field(std::uint64_t p, int axis) {
  return std::uint32_t(p >> (kStride * axis)) & kMax;
}
/// The bit above a coordinate.
constexpr std::uint64_t guard(int axis) {
  return std::uint64_t{1} << (kStride * axis + kBits);
}
/// Replaces one coordinate.
constexpr std::uint64_t with_field(std::uint64_t p, int axis, std::uint32_t value) {
  return (p & ~(std::uint64_t{kMax} << (kStride * axis))) | std::uint64_t{value} << (kStride * axis);
}
/// True if a <= b on every axis.
constexpr bool all_le(std::uint64_t a, std::uint64_t b) {
  return (((b | kGuards) - a) & kGuards) == kGuards;
}

}  // namespace packed

/// A box of a tile, in packed coordinates. They count from 1 at the low corner of the tile. 0 stands for
/// everything below the tile, and size + 1 for its upper end and everything beyond.
struct PackedBox {
  std::uint64_t lo = 0, hi = 0;
  friend bool operator==(const PackedBox&, const PackedBox&) = default;
  friend auto operator<=>(const PackedBox&, const PackedBox&) = default;
};

/// Boxes of a tile as words: one for a short box that begins in the tile, otherwise two. A box is short if
/// its edges fit the bits that coordinates do not need: in a tile of 2^11 ordinals on each axis, edges below
/// 2^10.
class PackedWords {
 public:
  /// For tiles with edges of at most 2^log_edge ordinals.
  explicit PackedWords(int log_edge)
      : log_edge_(log_edge),
        lo_mask_(kOnes * ((1u << log_edge) - 1)),
        extent_mask_(kOnes * ((1u << (packed::kBits + 1 - log_edge)) - 1)) {}

  /// Calls put(word) for each word of a box, in order.
  template <class Put>
  void encode(const PackedBox& box, Put&& put) const {
    const std::uint64_t extent = box.hi - box.lo;
    if ((extent & ~extent_mask_) == 0 && packed::all_le(kOnes, box.lo)) [[likely]]
      return put((box.lo - kOnes) | extent << log_edge_);
    put(box.lo | kTwo);
    put(box.hi);
  }

  /// Reads the words of a tile one after the other. Returns true if a word completes `box`. Otherwise,
  /// `first` keeps the word for the next call. `first` must be 0 at the start.
  bool decode(std::uint64_t word, std::uint64_t& first, PackedBox& box) const {
    if ((word & kTwo) != 0 || first != 0) [[unlikely]] {
      box = {first & ~kTwo, word};
      first = first == 0 ? word : 0;
      return first == 0;
    }
    const std::uint64_t lo = (word & lo_mask_) + kOnes;
    box = {lo, lo + (word >> log_edge_ & extent_mask_)};
    return true;
  }

 private:
  static constexpr std::uint64_t kOnes = packed::pack(1, 1, 1), kTwo = std::uint64_t{1} << 63;
  int log_edge_;
  std::uint64_t lo_mask_, extent_mask_;
};

/// A region [lo, hi) of a tile, packed like its boxes.
///
/// It owns the points lo <= p < hi on every axis. The boxes that touch it decide everything about these
/// points. A region covered by one box has no vertex.
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

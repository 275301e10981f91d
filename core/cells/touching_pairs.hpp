#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/cells/packed.hpp"

namespace boxunion {

/// Finds the pairs of boxes that touch each other, whatever their shapes, even rods through the whole tile.
/// After Zomorodian and Edelsbrunner, "Fast software for box intersections", 2002: on one axis after the
/// other, boxes are divided at the median of their low ends. A box that spans a whole part is compared with
/// that part on the remaining axes. Takes O(boxes log^2 boxes + pairs) time if few boxes touch.
class TouchingPairs {
 public:
  using Take = std::function<void(std::uint32_t, std::uint32_t)>;

  /// Calls take(i, j) for every pair of boxes that touch, possibly several times. Gives up and returns false
  /// after `most` calls.
  bool find(std::span<const PackedBox> boxes, std::size_t most, const Take& take);

 private:
  using Indices = std::vector<std::uint32_t>;
  using Items = std::span<const std::uint32_t>;
  /// A part of an axis: lo <= p < hi.
  struct Part {
    std::uint32_t lo, hi;
  };
  static constexpr Part kWhole{0, packed::kMax + 1};

  void divide(Items spans, Items points, Part part, int axis);
  void divide_on_next_axis(Items spans, Items points, int axis);
  void scan(Items spans, Items points);
  void compare_all(Items spans, Items points);
  void compare(std::uint32_t i, std::uint32_t j);
  std::uint32_t low(std::uint32_t i, int axis) const { return packed::field(boxes_[i].lo, axis); }
  std::uint32_t high(std::uint32_t i, int axis) const { return packed::field(boxes_[i].hi, axis); }

  std::span<const PackedBox> boxes_;
  const Take* take_ = nullptr;
  std::size_t left_ = 0;  // remaining calls
};

}  // namespace boxunion

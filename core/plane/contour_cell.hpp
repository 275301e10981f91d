#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/contour.hpp"
#include "core/base/memory.hpp"
#include "core/boxes/ordinals.hpp"

namespace boxunion {

/// Finds the vertices of a union of rectangles in one cell of the plane at a time, by a bitmap of at most 64
/// x 64 bits between the coordinates of the cell. A cell with more coordinates is halved. As in three
/// dimensions, a cell owns the points lo <= p < hi, and the rectangles that touch it decide everything about
/// them.
class ContourCell {
 public:
  /// Appends the vertices of a cell to `out`. On every row, x ascends. Returns true if the rows ascend, too.
  bool find(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
            Array<ContourVertex>& out);

  static constexpr std::uint32_t kBits = 64;
  /// Maximum number of vertices from one bitmap.
  static constexpr std::size_t kMost = std::size_t{kBits} * kBits;

 private:
  /// The places of a cell's bits along one axis. Bit 0 lies below the first place that the cell owns, bit i
  /// above place i - 1. The places are all ordinals of a narrow cell, and the ordinals that occur in any
  /// other cell.
  class Places {
   public:
    /// Finds the places. False if there are more than a row of bits has room for.
    bool assign(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles, unsigned axis);
    std::uint32_t count() const { return count_; }
    /// The ordinal below each bit; arbitrary for bit 0.
    const std::uint32_t* ordinals() const { return ordinals_.data(); }
    /// An ordinal that halves the places.
    std::uint32_t middle() const { return ordinals_[count_ / 2 + 1]; }
    /// The first bit of each rectangle and the one after its last.
    struct Range {
      std::uint16_t begin, end;
    };
    std::span<const Range> ranges() const { return std::span(ranges_).first(range_count_); }

   private:
    static constexpr std::uint32_t kMarked = 1u << 15;  // ordinals of a cell that are marked in a bitmap
    static constexpr std::size_t kCounted = 96;  // maximum number of rectangles that are ranked by counting

    bool is_direct() const { return extent_ < kBits; }
    /// The distance from the low end of the cell, counted from 1. 0 stands for everything lower, extent + 1
    /// for the high end and everything beyond.
    std::uint32_t offset(std::uint32_t ordinal) const {
      return std::clamp(ordinal, lo_ - 1, lo_ + extent_) - (lo_ - 1);
    }
    void make_ordinals() { ordinals_.resize(std::max(ordinals_.size(), std::size_t{kBits} + 2)); }
    void make_ranges(std::size_t count) {
      range_count_ = count;
      ranges_.resize(std::max({ranges_.size(), count, kCounted}));
    }
    template <class Bit>
    void set_ranges(std::span<const OrdinalRectangle> rectangles, unsigned axis, Bit&& bit);
    template <class Lane>
    bool find_by_counting(std::span<const OrdinalRectangle> rectangles, unsigned axis);
    void find_by_marks(std::span<const OrdinalRectangle> rectangles, unsigned axis);
    void find_by_sorting(std::span<const OrdinalRectangle> rectangles, unsigned axis);

    std::uint32_t lo_ = 0, extent_ = 0, count_ = 0;
    std::vector<std::uint32_t> ordinals_;  // by the bit above them, ascending
    std::vector<std::uint64_t> marks_;     // by offset; all zero between calls
    std::vector<std::uint8_t> bits_;       // by marked offset
    std::vector<Range> ranges_;            // with room for more
    std::size_t range_count_ = 0;
  };

  bool halve(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles, unsigned axis,
             Array<ContourVertex>& out);
  void fill();
  void emit(Array<ContourVertex>& out) const;

  std::array<Places, 2> places_;
  std::array<std::uint64_t, kBits> rows_{};
  std::uint64_t occurring_ = 0;  // bits of the rows above which a rectangle begins or ends
};

}  // namespace boxunion

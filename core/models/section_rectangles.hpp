#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/base/sorted_chunks.hpp"
#include "core/models/section_cells.hpp"
#include "core/models/sections.hpp"

namespace boxunion {

/// The section of a sweep along A, cut into rectangles. From every vertex of the section, a cut runs along C
/// through the inside. (These are the intervals between neighboring lines of vertices, with equal neighbors
/// along B merged: what CUDB does to a slice.)
///
/// A plane of vertices changes only rectangles that touch the region that it flips. These are taken apart and
/// made anew. Each of them changes or has a vertex of the solid, so their number is bounded by input and
/// output. To find them without looking at the whole section for every plane, planes are passed in batches as
/// large as the section. Rectangles that touch nothing of a batch are set aside. The same is done with each
/// half of the batch and the remaining rectangles, down to a few planes or rectangles. A sweep therefore
/// takes O(n log^2 n) time for n vertices and boxes. Coordinates are of type C: ordinals, or the 64-bit
/// numbers of OrderedPoint.
template <class C>
class SectionRectangles {
 public:
  using Rectangle = SectionRectangle<C>;
  using Vertex = OrderedPoint<3, C>;

  /// Passes the planes of some sorted vertices. For each plane, calls begin(rectangle, a) for every new
  /// rectangle, in the order of their low corners, and end(rectangle, a) for every rectangle that ends. begin
  /// returns the mark of the rectangle.
  template <class Begin, class End>
  void pass(std::span<const Vertex> vertices, Begin&& begin, End&& end) {
    while (!vertices.empty()) {
      vertices = vertices.subspan(take_batch(vertices));
      pass_planes(0, planes_.size() - 1, rectangles_, 0, begin, end);
    }
  }

  /// The whole section, sorted by low corners.
  std::span<const Rectangle> all() const { return rectangles_; }
  /// The number of vertices of a batch, if there are so many; whole planes may make it more.
  std::size_t batch() const { return std::max(kLeastBatch, rectangles_.size()); }
  /// The bytes that it holds.
  std::size_t bytes() const;
  /// The work so far: the number of rectangles, cells and vertices looked at.
  std::uint64_t steps() const { return steps_; }

 private:
  static constexpr C kEnd = std::numeric_limits<C>::max();  // above every coordinate
  static constexpr std::size_t kLeastBatch = 1 << 10;
  static constexpr std::size_t kMostDepth = 64;  // of halving a batch

  using Cell = SectionCell<C>;
  /// A plane of the batch. Its vertices and cells end where those of the next plane begin.
  struct Plane {
    const Vertex* vertices;
    std::size_t cell;
  };
  /// A rectangle on the line of the sweep along B.
  struct Interval {
    C c_lo, c_hi;
    std::size_t rectangle;  // in renewed_
  };
  using Place = typename SortedChunks<Interval>::Place;
  struct HighEnd {
    C b_hi, c_lo, c_hi;
  };

  static auto low_corner(const Rectangle& r) { return PointKey()(OrderedPoint<2, C>{r.b_lo, r.c_lo}); }

  std::size_t take_batch(std::span<const Vertex> vertices);
  void add_cells();
  bool is_small(std::size_t first, std::size_t last, std::size_t rectangles) const;
  template <class Begin, class End>
  void pass_planes(std::size_t first, std::size_t last, std::vector<Rectangle>& list, std::size_t depth,
                   Begin&& begin, End&& end);
  void take_touched(std::size_t first, std::size_t last, std::vector<Rectangle>& list,
                    std::vector<Rectangle>& touched);
  void take_marked(std::size_t count, std::vector<Rectangle>& list, std::vector<Rectangle>& taken);
  void project(std::span<const Vertex> plane);
  void renew(std::span<const Rectangle> touched);
  void find_flips();
  void change_line(C b);
  Place change_intervals(C b, Place place, const C*& flip);
  template <class Begin, class End>
  void compare(C a, Begin&& begin, End&& end);
  void put_back(std::span<const Rectangle> rectangles, std::vector<Rectangle>& list);

  std::vector<Rectangle> rectangles_;  // sorted by low corners, like all lists of them here
  std::uint64_t steps_ = 0;

  std::vector<Plane> planes_;  // of the batch, and one behind them
  std::vector<Cell> cells_;    // of the regions that the planes flip
  std::array<std::vector<Rectangle>, kMostDepth>
      parts_;  // by depth: rectangles that a half of a batch touches
  CellGrid<C> grid_;
  CellReach<C> reach_;
  std::vector<std::uint8_t> touches_;

  ExtremeVertices<2, C> plane_;
  std::vector<Rectangle> touched_, renewed_;
  std::vector<HighEnd> ends_, sorting_;  // of the touched rectangles, sorted
  SortedChunks<Interval> line_;
  std::vector<Interval> window_;
  std::vector<C> begin_points_, end_points_, plane_points_, flips_;  // on a line
};

// ---- implementation ----

/// Passes planes first .. last - 1 of the batch. `list` has all rectangles that these touch, and others.
template <class C>
template <class Begin, class End>
void SectionRectangles<C>::pass_planes(std::size_t first, std::size_t last, std::vector<Rectangle>& list,
                                       std::size_t depth, Begin&& begin, End&& end) {
  for (; first < last && is_small(first, last, list.size()); ++first) {
    take_touched(first, first + 1, list, touched_);
    project({planes_[first].vertices, planes_[first + 1].vertices});
    renew(touched_);
    compare((*planes_[first].vertices)[0], begin, end);
    put_back(renewed_, list);
  }
  if (first == last) return;
  const std::size_t middle = first + (last - first) / 2;
  std::vector<Rectangle>& part = parts_[depth];
  for (const auto& [from, to] : {std::pair(first, middle), std::pair(middle, last)}) {
    take_touched(from, to, list, part);
    pass_planes(from, to, part, depth + 1, begin, end);
    put_back(part, list);
  }
}

template <class C>
template <class Begin, class End>
void SectionRectangles<C>::compare(C a, Begin&& begin, End&& end) {
  auto old = touched_.begin();
  for (Rectangle& r : renewed_) {
    for (; old != touched_.end() && low_corner(*old) < low_corner(r); ++old) end(*old, a);
    if (old != touched_.end() && low_corner(*old) == low_corner(r)) {
      const bool same = old->b_hi == r.b_hi && old->c_hi == r.c_hi;
      if (same)
        r.mark = old->mark;
      else
        end(*old, a);
      ++old;
      if (same) continue;
    }
    r.mark = begin(r, a);
  }
  for (; old != touched_.end(); ++old) end(*old, a);
}

}  // namespace boxunion

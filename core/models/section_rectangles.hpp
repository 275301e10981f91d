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
#include "core/models/evm.hpp"
#include "core/models/section_cells.hpp"

namespace boxunion {

/// The section of a sweep along A, cut into rectangles along C: from every vertex of the section a cut runs
/// along C through the inside. (Of each line between lines of vertices these are its intervals, equal
/// neighbors along B merged: what CUDB does to a slice.)
///
/// A plane of vertices changes only rectangles that touch the region that it flips; these are taken apart and
/// made anew. Each of them changes or has a vertex of the solid, so they are no more than what goes in and
/// comes out. To find them without a look at the whole section for every plane, planes are passed in batches
/// as large as the section. What touches none of a batch is set aside; then the same with each half of the
/// batch and what is left, down to a few planes or rectangles. So a sweep takes O(n log^2 n) time for n
/// vertices and boxes. Coordinates are of type C: ordinals, or the 64-bit numbers of OrderedPoint.
template <class C>
class SectionRectangles {
 public:
  using Rectangle = SectionRectangle<C>;
  using Vertex = OrderedPoint<3, C>;

  /// Passes the planes of some vertices, sorted. Of each, calls begin(rectangle, a) for every new rectangle,
  /// in the order of their low corners, which gives its mark, and end(rectangle, a) for every one that is no
  /// more.
  template <class Begin, class End>
  void pass(std::span<const Vertex> vertices, Begin&& begin, End&& end) {
    while (!vertices.empty()) {
      vertices = vertices.subspan(take_batch(vertices));
      pass_planes(0, planes_.size() - 1, rectangles_, 0, begin, end);
    }
  }

  /// All of the section, sorted by their low corners.
  std::span<const Rectangle> all() const { return rectangles_; }
  /// So many vertices make up a batch, or more, where they are there.
  std::size_t batch() const { return std::max(kLeastBatch, rectangles_.size()); }
  /// The memory that it holds.
  std::size_t bytes() const;
  /// The work so far: how many rectangles, cells and vertices it has looked at.
  std::uint64_t steps() const { return steps_; }

 private:
  static constexpr C kEnd = std::numeric_limits<C>::max();  // above every coordinate
  static constexpr std::size_t kLeastBatch = 1 << 10;
  static constexpr std::size_t kMostDepth = 64;  // of halves of a batch

  using Cell = SectionCell<C>;
  /// A plane of the batch; the next one tells where its vertices and cells end.
  struct Plane {
    const Vertex* vertices;
    std::size_t cell;
  };
  /// A rectangle on the line that sweeps along B.
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

  std::vector<Rectangle> rectangles_;  // sorted by their low corners, as all lists of them here
  std::uint64_t steps_ = 0;

  std::vector<Plane> planes_;                             // of the batch, and one behind them
  std::vector<Cell> cells_;                               // of the regions that these flip
  std::array<std::vector<Rectangle>, kMostDepth> parts_;  // by depth: what a half of a batch touches
  CellGrid<C> grid_;
  CellReach<C> reach_;
  std::vector<std::uint8_t> touches_;

  ExtremeVertices<2, C> plane_;
  std::vector<Rectangle> touched_, renewed_;
  std::vector<HighEnd> ends_, sorting_;  // of the touched rectangles, sorted
  SortedChunks<Interval> line_;
  std::vector<Interval> window_;
  std::vector<C> begin_points_, end_points_, plane_points_, flips_;  // of a line
};

// ---- implementation ----

/// Passes planes first .. last - 1 of the batch; `list` has all rectangles that these touch, and others.
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

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/evm.hpp"

namespace boxunion {

/// A rectangle of a section, on B and C, and what its maker wants to remember of it.
template <class C>
struct SectionRectangle {
  C b_lo, c_lo, b_hi, c_hi;
  C mark;
};

/// The section of a sweep along A, cut into rectangles along C: from every vertex of the section a cut runs
/// along C through the inside. (Of each line between lines of vertices these are its intervals, equal
/// neighbours along B merged: what CUDB does to a slice.)
///
/// A plane of vertices changes only rectangles that reach the region that it flips; only those that reach the
/// bounds of a part of it are taken apart and made anew. Coordinates are of type C: ordinals, or the 64-bit
/// numbers of OrderedPoint.
template <class C>
class SectionRectangles {
 public:
  using Rectangle = SectionRectangle<C>;

  /// Passes a plane of vertices (sorted, projected). Calls begin(rectangle) for every new one, in the order
  /// of their low corners, which gives its mark, and end(rectangle) for every one that is no more.
  template <class Begin, class End>
  void pass(const ExtremeVertices<2, C>& plane, Begin&& begin, End&& end) {
    find_changes(plane);
    take_touched();
    renew(plane);
    compare(begin, end);
    put_back();
  }

  /// All of the section, sorted by their low corners.
  std::span<const Rectangle> all() const { return rectangles_; }
  /// The memory that it holds.
  std::size_t bytes() const;

 private:
  /// A rectangle on the line that sweeps along B.
  struct Interval {
    C c_lo, c_hi;
    std::size_t rectangle;  // in renewed_
  };
  struct HighEnd {
    C b_hi, c_lo, c_hi;
  };
  struct Bounds {
    C b_lo, c_lo, b_hi, c_hi;
  };

  static auto low_corner(const Rectangle& r) { return PointKey()(OrderedPoint<2, C>{r.b_lo, r.c_lo}); }

  void find_changes(const ExtremeVertices<2, C>& plane);
  void take_touched();
  void renew(const ExtremeVertices<2, C>& plane);
  void change_line(C b, const ExtremeVertices<1, C>& flips);
  template <class Begin, class End>
  void compare(Begin&& begin, End&& end);
  void put_back();

  std::vector<Rectangle> rectangles_;  // sorted by their low corners, as all lists of them here
  std::vector<Bounds> changes_;        // of the flipped region's parts along B, in that order, closed
  std::vector<Rectangle> touched_, untouched_, renewed_, merged_;
  std::vector<HighEnd> ends_, sorting_;  // of the touched rectangles, sorted
  std::vector<Interval> line_, window_;
  ExtremeVertices<1, C> begin_points_, end_points_, plane_points_, moved_, flips_, old_points_, new_points_;
};

// ---- implementation ----

template <class C>
template <class Begin, class End>
void SectionRectangles<C>::compare(Begin&& begin, End&& end) {
  auto old = touched_.begin();
  for (Rectangle& r : renewed_) {
    for (; old != touched_.end() && low_corner(*old) < low_corner(r); ++old) end(*old);
    if (old != touched_.end() && low_corner(*old) == low_corner(r)) {
      const bool same = old->b_hi == r.b_hi && old->c_hi == r.c_hi;
      if (same)
        r.mark = old->mark;
      else
        end(*old);
      ++old;
      if (same) continue;
    }
    r.mark = begin(r);
  }
  for (; old != touched_.end(); ++old) end(*old);
}

}  // namespace boxunion

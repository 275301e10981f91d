#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ordered_bitset.hpp"
#include "core/boundary/planes.hpp"

namespace boxunion {

namespace detail {

/// The intervals of a sweep by the column of their left ends, for few intervals at a time.
template <class Interval, std::size_t most>
class FewIntervals {
 public:
  /// The interval that begins at a column, which must have one.
  Interval& at(std::uint32_t column) { return intervals_[place(column)]; }
  /// Removes and returns it.
  Interval take(std::uint32_t column) {
    const std::size_t i = place(column);
    const Interval interval = intervals_[i];
    columns_[i] = columns_[--size_];
    intervals_[i] = intervals_[size_];
    return interval;
  }
  /// The last interval that begins left of a column. There must be one.
  Interval& below(std::uint32_t column) {
    std::size_t last = 0;
    while (columns_[last] >= column) ++last;
    for (std::size_t i = last + 1; i < size_; ++i)
      last = columns_[i] < column && columns_[i] > columns_[last] ? i : last;
    return intervals_[last];
  }
  void insert(std::uint32_t column, const Interval& interval) {
    columns_[size_] = column;
    intervals_[size_++] = interval;
  }

 private:
  std::size_t place(std::uint32_t column) const {
    std::size_t i = 0;
    while (columns_[i] != column) ++i;
    return i;
  }

  std::size_t size_ = 0;
  std::array<std::uint32_t, most> columns_;
  std::array<Interval, most> intervals_;
};

/// The same for many intervals at a time. Columns must be less than a bound.
template <class Interval>
class ManyIntervals {
 public:
  void reserve(std::uint32_t columns) {
    if (columns <= intervals_.size()) return;
    intervals_.resize(columns);
    starts_ = OrderedBitset(columns);
  }
  Interval& at(std::uint32_t column) { return intervals_[column]; }
  Interval take(std::uint32_t column) {
    starts_.erase(column);
    return intervals_[column];
  }
  Interval& below(std::uint32_t column) { return intervals_[starts_.below(column)]; }
  void insert(std::uint32_t column, const Interval& interval) {
    intervals_[column] = interval;
    starts_.insert(column);
  }

 private:
  std::vector<Interval> intervals_;
  OrderedBitset starts_;  // empty after every sweep
};

}  // namespace detail

/// A vertex of a sweep.
struct SweepVertex {
  std::uint32_t id;  ///< passed to the events
  std::uint32_t column;
  std::uint32_t quadrants;  ///< filled by faces; never none or all
};

/// Sweeps the faces of one plane and direction, row by row from left to right.
///
/// The line of the sweep is tilted a little, so that it meets one vertex at a time. Left of that vertex the
/// line is already above the row; right of it, the line is still below. The line cuts the faces into
/// intervals. A vertex begins, changes or ends intervals. Which of them depends on the quadrants around it
/// that a face fills (bit 0: left below, 1: right below, 2: left above, 3: right above). The visitor has a
/// member for each event:
///
///   event                   quadrants             effect
///   start(i) -> interval    right above only      an interval begins
///   end(a, i)               left below only       interval a ends
///   left(a, i)              others                the left end of interval a continues from vertex i
///   right(a, i)             others                the right end of interval a continues from vertex i
///   split(a, i) -> interval all but right above   a keeps its left part; the result is its right part
///   merge(a, b, i)          all but left below    a takes in b, which lies to its right
///
/// Two diagonal quadrants cause two events, one for each quadrant.
template <class Interval>
class FaceSweep {
 public:
  /// The maximum number of vertices of a small sweep.
  static constexpr std::size_t kSmall = 64;

  /// `vertices` is a range of SweepVertex in order of row and column. Every boundary edge of the faces runs
  /// between neighbors on a row or column. Columns are less than `columns`, or arbitrary if there are at most
  /// kSmall vertices.
  template <class Vertices, class Visitor>
  void run(const Vertices& vertices, std::uint32_t columns, Visitor&& visitor) {
    if (vertices.size() <= kSmall) {
      // enough, because every interval began at two vertices of its own
      detail::FewIntervals<Interval, kSmall / 2> few;
      sweep(few, vertices, visitor);
    } else {
      many_.reserve(columns);
      sweep(many_, vertices, visitor);
    }
  }

 private:
  template <class Intervals, class Vertices, class Visitor>
  static void sweep(Intervals& intervals, const Vertices& vertices, Visitor& visitor) {
    Interval open{};  // the interval whose left end is the edge on this row
    for (const auto [i, c, quadrants] : vertices) {
      switch (quadrants) {
        case bits(right_above):
          intervals.insert(c, visitor.start(i));
          break;
        case bits(left_below):
          visitor.end(open, i);
          break;
        case bits(left_below, right_above):
          visitor.end(open, i);
          intervals.insert(c, visitor.start(i));
          break;
        case bits(left_above):
        case bits(left_above, left_below):
        case bits(left_above, right_above):
        case bits(left_above, right_above, left_below):
          visitor.right(intervals.below(c), i);
          break;
        case bits(right_below):
          open = intervals.take(c);
          visitor.left(open, i);
          break;
        case bits(right_below, right_above):
          visitor.left(intervals.at(c), i);
          break;
        case bits(right_below, left_below):
          visitor.left(open, i);
          break;
        case bits(right_below, left_below, right_above):
          visitor.left(open, i);
          intervals.insert(c, open);
          break;
        case bits(right_below, left_above):
          open = intervals.take(c);
          visitor.left(open, i);
          visitor.right(intervals.below(c), i);
          break;
        case bits(left_below, right_below, left_above):
          open = visitor.split(intervals.below(c), i);
          break;
        case bits(right_below, left_above, right_above): {
          Interval right_part = intervals.take(c);
          visitor.merge(intervals.below(c), right_part, i);
          break;
        }
        default:
          break;
      }
    }
  }

  template <class... Quadrants>
  static constexpr unsigned bits(Quadrants... quadrants) {
    return ((1u << quadrants) | ...);
  }

  detail::ManyIntervals<Interval> many_;
};

}  // namespace boxunion

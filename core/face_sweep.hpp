#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/ordered_bitset.hpp"

namespace boxunion {

namespace detail {

/// The intervals of a sweep by the column of their left ends, where there are few at a time.
template <class Interval, class Column, std::size_t most>
class FewIntervals {
 public:
  /// The interval that begins at a column, which one does.
  Interval& at(Column column) {
    std::size_t i = 0;
    while (columns_[i] != column) ++i;
    return intervals_[i];
  }
  /// The last one that begins left of a column, where there is one.
  Interval& below(Column column) {
    std::size_t last = 0;
    while (columns_[last] >= column) ++last;
    for (std::size_t i = last + 1; i < size_; ++i)
      last = columns_[i] < column && columns_[i] > columns_[last] ? i : last;
    return intervals_[last];
  }
  void insert(Column column, const Interval& interval) {
    columns_[size_] = column;
    intervals_[size_++] = interval;
  }
  void erase(Column column) {
    const std::size_t i = std::size_t(&at(column) - intervals_.data());
    columns_[i] = columns_[--size_];
    intervals_[i] = intervals_[size_];
  }

 private:
  std::size_t size_ = 0;
  std::array<Column, most> columns_;
  std::array<Interval, most> intervals_;
};

/// The same for many at a time; columns are less than a bound.
template <class Interval>
class ManyIntervals {
 public:
  void reserve(std::uint32_t columns) {
    if (columns <= intervals_.size()) return;
    intervals_.resize(columns);
    starts_ = OrderedBitset(columns);
  }
  Interval& at(std::uint32_t column) { return intervals_[column]; }
  Interval& below(std::uint32_t column) { return intervals_[starts_.below(column)]; }
  void insert(std::uint32_t column, const Interval& interval) {
    intervals_[column] = interval;
    starts_.insert(column);
  }
  void erase(std::uint32_t column) { starts_.erase(column); }

 private:
  std::vector<Interval> intervals_;
  OrderedBitset starts_;  // empty after every sweep
};

}  // namespace detail

/// Sweeps the faces of one plane and direction, row by row from left to right.
///
/// The line of the sweep is tilted a little, so that it meets one vertex at a time: left of it the line is
/// already above the row, right of it still below. It cuts the faces into intervals. A vertex ends some of
/// them and begins others, as the quadrants around it say that a face fills (bit 0: left below, 1: right
/// below, 2: left above, 3: right above):
///
///   start(i)           -> interval   only right above: an interval begins
///   end(a, i)                        only left below: interval a ends
///   left(a, i)                       the left end of interval a goes on from vertex i
///   right(a, i)                      the right end does
///   split(a, i)        -> interval   all but right above: a keeps its left part, the result is its right
///   part merge(a, b, i)                   all but left below: a takes in b, which lies right of it
///
/// At two diagonal quadrants two of these come, each for its own quadrant.
template <class Interval>
class FaceSweep {
 public:
  /// The most vertices of a small sweep.
  static constexpr std::size_t kSmall = 64;

  /// Vertices 0 .. count - 1 lie in order of row and column; column(i) is an integer less than `columns`,
  /// and quadrants(i) is 0 where no face is at hand. Every boundary edge of the faces runs between neighbours
  /// on a row or column.
  template <class Column, class Quadrants, class Visitor>
  void run(std::size_t count, std::uint32_t columns, Column&& column, Quadrants&& quadrants,
           Visitor&& visitor) {
    many_.reserve(columns);
    sweep(many_, count, column, quadrants, visitor);
  }

  /// The same for at most kSmall vertices, which may have any columns.
  template <class Column, class Quadrants, class Visitor>
  void run_small(std::size_t count, Column&& column, Quadrants&& quadrants, Visitor&& visitor) {
    // Every interval began at two vertices of its own.
    detail::FewIntervals<Interval, std::decay_t<decltype(column(0))>, kSmall / 2> few;
    sweep(few, count, column, quadrants, visitor);
  }

 private:
  template <class Intervals, class Column, class Quadrants, class Visitor>
  static void sweep(Intervals& intervals, std::size_t count, Column&& column, Quadrants&& quadrants,
                    Visitor&& visitor) {
    Interval open{};  // the interval whose left end is the edge on this row
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned q = quadrants(i);
      if (q == 0) continue;
      const auto c = column(i);
      const bool left_below = q & 1u, right_below = q & 2u, left_above = q & 4u, right_above = q & 8u;
      if (q == 7u) {
        open = visitor.split(intervals.below(c), i);
      } else if (q == 14u) {
        visitor.merge(intervals.below(c), intervals.at(c), i);
        intervals.erase(c);
      } else {
        if (right_below) {
          if (!left_below) {
            open = intervals.at(c);
            intervals.erase(c);
          }
          visitor.left(open, i);
          if (right_above) intervals.insert(c, open);
        }
        if (left_above) visitor.right(intervals.below(c), i);
        if (!right_below && !left_above) {
          if (left_below) visitor.end(open, i);
          if (right_above) intervals.insert(c, visitor.start(i));
        }
      }
    }
  }

  detail::ManyIntervals<Interval> many_;
};

}  // namespace boxunion

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/ordered_bitset.hpp"

namespace boxunion {

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
  /// Vertices 0 .. count - 1 lie in order of row and column; column(i) is less than `columns`, and
  /// quadrants(i) is 0 where no face is at hand. Every boundary edge of the faces runs between neighbours on
  /// a row or column.
  template <class Column, class Quadrants, class Visitor>
  void run(std::size_t count, std::uint32_t columns, Column&& column, Quadrants&& quadrants,
           Visitor&& visitor) {
    if (columns > intervals_.size()) {
      intervals_.resize(columns);
      starts_ = OrderedBitset(columns);
    }
    Interval open{};  // the interval whose left end is the edge on this row
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned q = quadrants(i);
      if (q == 0) continue;
      const std::uint32_t c = column(i);
      const bool left_below = q & 1u, right_below = q & 2u, left_above = q & 4u, right_above = q & 8u;
      if (q == 7u) {
        open = visitor.split(intervals_[starts_.below(c)], i);
      } else if (q == 14u) {
        visitor.merge(intervals_[starts_.below(c)], intervals_[c], i);
        starts_.erase(c);
      } else {
        if (right_below) {
          if (!left_below) {
            open = intervals_[c];
            starts_.erase(c);
          }
          visitor.left(open, i);
          if (right_above) begin(c, open);
        }
        if (left_above) visitor.right(intervals_[starts_.below(c)], i);
        if (!right_below && !left_above) {
          if (left_below) visitor.end(open, i);
          if (right_above) begin(c, visitor.start(i));
        }
      }
    }
  }

 private:
  void begin(std::uint32_t column, const Interval& interval) {
    intervals_[column] = interval;
    starts_.insert(column);
  }

  std::vector<Interval> intervals_;  // by the column of their left ends
  OrderedBitset starts_;             // those columns; empty after every sweep
};

}  // namespace boxunion

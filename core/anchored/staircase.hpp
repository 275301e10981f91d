#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/octants.hpp"
#include "core/base/memory.hpp"
#include "core/base/ordered_bitset.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {

// The union of boxes that share a corner, swept like the hypervolume of a front (Guerreiro, Fonseca 2018).
// Everything is relative to that corner: a box is [0, u] x [0, v] x [0, w], whichever way the axes run.
//
// A plane sweeps from the greatest w down to 0. The section above it is bounded by a staircase: a height, at
// least 0, that does not increase with u. A box whose corner lies above the staircase raises it, from u down
// to where it is as high already. All other boxes are dropped.

/// A box as its reach from the corner on each axis, in any numbers that grow with the reach. 0 is the corner.
struct AnchoredBox {
  std::uint64_t u, v, w;
};

/// A vertical line in a plane of the sweep, at some u. It has the height of the staircase on the side away
/// from the corner (outer) and towards it (inner), above the plane (at greater w) and below.
struct StairColumn {
  std::uint64_t u, outer_above, inner_above, outer_below, inner_below;
};

/// Calls f(v, mask) for the vertices of a column. The masks are for axes u, v, w.
template <class F>
constexpr void each_vertex(const StairColumn& column, F&& f) {
  const std::uint64_t heights[4] = {column.inner_below, column.outer_below, column.inner_above,
                                    column.outer_above};
  for (int i = 0; i < 4; ++i) {
    const std::uint64_t v = heights[i];
    bool seen = false;
    for (int j = 0; j < i; ++j) seen |= heights[j] == v;
    if (seen) continue;
    unsigned mask = 0;
    for (unsigned side = 0; side < 4; ++side) {  // u + 2 w
      const unsigned octant = (side & 1) + 4 * (side >> 1);
      mask |= unsigned(v > 0 && heights[side] >= v) << octant | unsigned(heights[side] > v) << (octant + 2);
    }
    if (kOctants[mask].vertex) f(v, mask);
  }
}

/// Boxes in the order of the sweep.
///
/// A visitor of the sweep has two members: column(StairColumn), called for every line with a vertex, and
/// plane(w), called after the columns of a plane in which something has changed. Where the staircase is
/// raised, columns come by falling u without a gap, from a column with equal outer heights to one with equal
/// inner heights.
class StairSweep {
 public:
  static constexpr std::size_t kMost = 0xfffffffe;  // boxes

  /// Leaves out boxes without extent on some axis.
  explicit StairSweep(Array<AnchoredBox> boxes);

  std::size_t size() const { return steps_.size(); }
  /// The number of parts that keeps the threads busy.
  std::size_t parts() const;
  /// The greatest reach on each axis.
  const AnchoredBox& bounds() const { return bounds_; }

  /// Sweeps in parts of similar size, one for each visitor, in parallel. The planes of a part lie below those
  /// of the part before.
  template <class Visitor>
  void sweep(std::span<Visitor> visitors) const;

 private:
  struct Step {
    std::uint64_t w, v;
    std::uint32_t rank;  // of its u; the greatest u has rank 0
  };

  /// The staircase, as a part of the sweep sees it.
  struct Front {
    explicit Front(std::size_t ranks) : corners(std::uint32_t(ranks)), heights(ranks) {}
    OrderedBitset corners;               // ranks of u where the outer side is lower
    std::vector<std::uint64_t> heights;  // by rank of a corner: the height on its inner side
  };

  /// The first step of part `part` of `parts`; it begins a plane.
  std::size_t begin(std::size_t part, std::size_t parts) const;
  Front front_before(std::size_t step) const;
  template <class Visitor>
  void sweep(Front& front, std::size_t first, std::size_t last, Visitor& visitor) const;
  template <class Visitor>
  bool lift(Front& front, std::span<const Step> plane, Visitor& visitor) const;
  template <class Visitor>
  void close(const Front& front, Visitor& visitor) const;

  Array<Step> steps_;       // by falling w, then by falling u
  Array<std::uint64_t> u_;  // by rank
  AnchoredBox bounds_{};
};

// ---- implementation ----

template <class Visitor>
void StairSweep::sweep(std::span<Visitor> visitors) const {
  const std::size_t parts = visitors.size();
  parallel_for_each(0, parts, 1, [&](std::size_t part) {
    const std::size_t first = begin(part, parts), last = begin(part + 1, parts);
    Front front = front_before(first);
    Visitor visitor = visitors[part];  // a copy, close to the other data of this thread
    sweep(front, first, last, visitor);
    if (part + 1 == parts && size() > 0) close(front, visitor);
    visitors[part] = std::move(visitor);
  });
}

template <class Visitor>
void StairSweep::sweep(Front& front, std::size_t first, std::size_t last, Visitor& visitor) const {
  constexpr std::size_t kCheck = 1 << 12;  // steps
  std::size_t check = first;
  for (std::size_t end = first; first < last; first = end) {
    if (first >= check) Interruptible::check(), check = first + kCheck;
    while (end < last && steps_[end].w == steps_[first].w) ++end;
    if (lift(front, std::span(steps_).subspan(first, end - first), visitor)) visitor.plane(steps_[first].w);
  }
}

/// Raises the staircase by the boxes of one plane. Returns false if it was as high already.
template <class Visitor>
bool StairSweep::lift(Front& front, std::span<const Step> plane, Visitor& visitor) const {
  constexpr std::uint32_t kNone = OrderedBitset::kNone;  // greater than every rank
  OrderedBitset& corners = front.corners;
  bool lifted = false;
  for (std::size_t i = 0; i < plane.size();) {
    std::uint32_t rank = plane[i].rank;
    const std::uint32_t outer = corners.below(rank);
    std::uint32_t corner = corners.contains(rank) ? rank : corners.above(rank);  // this corner or the next
    StairColumn c;
    c.outer_above = outer == kNone ? 0 : front.heights[outer];
    if (plane[i].v <= (corner == rank ? front.heights[rank] : c.outer_above)) {
      ++i;
      continue;
    }
    lifted = true;
    c.outer_below = c.outer_above;
    std::uint64_t height = 0;
    for (;;) {
      const bool at_corner = corner == rank;
      c.u = u_[rank];
      c.inner_above = at_corner ? front.heights[rank] : c.outer_above;
      for (; i < plane.size() && plane[i].rank == rank; ++i) height = std::max(height, plane[i].v);
      c.inner_below = std::max(c.inner_above, height);
      visitor.column(c);
      if (at_corner) corner = corners.above(rank);
      if (c.inner_below > c.outer_below) {
        if (!at_corner) corners.insert(rank);
        front.heights[rank] = c.inner_below;
      } else if (at_corner) {
        corners.erase(rank);
      }
      c.outer_above = c.inner_above, c.outer_below = c.inner_below;
      if (c.outer_above == c.outer_below) break;
      rank = i < plane.size() ? std::min(corner, plane[i].rank) : corner;
      if (rank == kNone) {
        c.u = c.inner_above = c.inner_below = 0;
        visitor.column(c);
        break;
      }
    }
  }
  return lifted;
}

/// Adds the plane of the corner itself, below which the union is empty.
template <class Visitor>
void StairSweep::close(const Front& front, Visitor& visitor) const {
  std::uint64_t height = 0;
  std::uint32_t rank = 0;  // the greatest u is always a corner
  for (; rank != OrderedBitset::kNone; rank = front.corners.above(rank)) {
    visitor.column({u_[rank], height, front.heights[rank], 0, 0});
    height = front.heights[rank];
  }
  visitor.column({0, height, 0, 0, 0});
  visitor.plane(0);
}

}  // namespace boxunion

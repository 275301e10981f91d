#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/models/section_rectangles.hpp"
#include "core/models/sections.hpp"

// Sweeps that cut a solid into disjoint boxes. They take its planes of extreme vertices one by one, in the
// order of A, and hold only the section between two planes and as many vertices. Coordinates are of type C:
// ordinals, or the 64-bit numbers of OrderedPoint.

namespace boxunion {

/// Calls f(plane, a) for every plane of sorted vertices. `plane` has the vertices without A.
template <class C, class F>
void for_each_plane(std::span<const OrderedPoint<3, C>> vertices, F&& f) {
  ExtremeVertices<2, C> plane;
  for (auto v = vertices.begin(); v != vertices.end();) {
    const C a = (*v)[0];
    plane.clear();
    for (; v != vertices.end() && (*v)[0] == a; ++v) plane.push_back({(*v)[1], (*v)[2]});
    f(plane, a);
  }
}

/// The OUDB: a box for every interval between neighboring lines of vertices of every section.
template <class C>
class OudbSweep {
 public:
  /// Passes a plane at `a`. Calls add(low corner, high corner) for the boxes between it and the plane before,
  /// in the order of their low corners.
  template <class Add>
  void pass(const ExtremeVertices<2, C>& plane, C a, Add&& add) {
    for (SectionSweep<2, C> lines{std::span(section_)}; lines.next() != lines.kEnd;) {
      Interruptible::check();
      const C b = lines.next();
      lines.advance();
      const ExtremeVertices<1, C>& ends = lines.section();
      for (std::size_t i = 0; i < ends.size(); i += 2)
        add(OrderedPoint<3, C>{a_, b, ends[i][0]}, OrderedPoint<3, C>{a, lines.next(), ends[i + 1][0]});
    }
    exclusive_or(section_, plane, scratch_);
    std::swap(section_, scratch_);
    a_ = a;
  }
  /// Call this after the last plane.
  template <class Add>
  void finish(Add&&) {}

  /// The bytes that the sweep needs for each vertex of the next plane, about, in addition to those that it
  /// holds.
  static constexpr std::size_t kVertexBytes = 3 * sizeof(OrderedPoint<2, C>);
  std::size_t bytes() const {
    return (section_.capacity() + scratch_.capacity()) * sizeof(OrderedPoint<2, C>);
  }

 private:
  C a_ = 0;
  ExtremeVertices<2, C> section_, scratch_;
};

/// The CUDB: a box lasts as long as its rectangle belongs to the section.
template <class C>
class CudbSweep {
 public:
  /// Passes a plane at `a`. Calls add(low corner, high corner) for boxes that have ended, in the order of
  /// their ends. finish() adds the last ones.
  template <class Add>
  void pass(const ExtremeVertices<2, C>& plane, C a, Add&& add) {
    for (const auto& [b, c] : plane) vertices_.push_back({a, b, c});
    if (vertices_.size() >= rectangles_.batch()) finish(add);
  }
  /// Call this after the last plane.
  template <class Add>
  void finish(Add&& add) {
    using Rectangle = SectionRectangle<C>;
    rectangles_.pass(
        std::span(vertices_), [](const Rectangle&, C a) { return a; },
        [&](const Rectangle& r, C a) {
          add(OrderedPoint<3, C>{r.mark, r.b_lo, r.c_lo}, OrderedPoint<3, C>{a, r.b_hi, r.c_hi});
        });
    vertices_.clear();
  }

  /// The bytes that the sweep needs for each vertex of the next plane, about, in addition to those that it
  /// holds.
  static constexpr std::size_t kVertexBytes =
      4 * sizeof(SectionRectangle<C>) + 2 * sizeof(OrderedPoint<3, C>);
  std::size_t bytes() const {
    return rectangles_.bytes() + vertices_.capacity() * sizeof(OrderedPoint<3, C>);
  }
  /// The work so far: SectionRectangles::steps().
  std::uint64_t steps() const { return rectangles_.steps(); }

 private:
  SectionRectangles<C> rectangles_;
  ExtremeVertices<3, C> vertices_;  // of waiting planes, until there are as many as in the section
};

}  // namespace boxunion

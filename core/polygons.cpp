#include "core/polygons.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <ranges>
#include <span>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/face_sweep.hpp"
#include "core/memory.hpp"
#include "core/parallel.hpp"
#include "core/radix_sort.hpp"

namespace boxunion {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::uint8_t kUp = 4;  // direction of faces

/// Links the corners of all loops, counter-clockwise. Corner i is that of vertex i; where two corners touch,
/// the second one has a number of its own, from the number of vertices on.
class LoopLinks {
 public:
  /// The corners where the edges at both ends of an interval begin.
  struct Interval {
    std::uint32_t left, right;
  };
  /// Where a loop may be lowest: a corner that starts an interval or, of a hole, splits one, whose left end
  /// is then on a loop of the same polygon that is lower still.
  struct Beginning {
    std::uint32_t corner, beside;
  };

  explicit LoopLinks(std::size_t vertices) : vertices_(vertices) {
    with_memory("the loops", vertices * sizeof(std::uint32_t), [&] {
      next_.resize(vertices);
      beginnings_.reserve(vertices / 2);  // seldom more, and what is not used takes no memory
    });
  }

  std::size_t corners() const { return next_.size(); }
  std::uint32_t& next(std::uint32_t corner) { return next_[corner]; }
  std::uint32_t vertex(std::uint32_t corner) const {
    return corner < vertices_ ? corner : second_[corner - vertices_];
  }
  std::span<const Beginning> beginnings() const { return beginnings_; }

  Interval start(std::size_t i) {
    const std::uint32_t c = corner(i);
    beginnings_.push_back({c, kNone});
    return {c, c};
  }
  void end(const Interval& a, std::size_t i) {
    const std::uint32_t c = corner(i);
    next_[a.right] = c;
    next_[c] = a.left;
  }
  void left(Interval& a, std::size_t i) {
    const std::uint32_t c = corner(i);
    next_[c] = a.left;
    a.left = c;
  }
  void right(Interval& a, std::size_t i) {
    const std::uint32_t c = corner(i);
    next_[a.right] = c;
    a.right = c;
  }
  Interval split(Interval& a, std::size_t i) {
    const std::uint32_t c = corner(i);
    beginnings_.push_back({c, a.left});
    const Interval right_part = {c, a.right};
    a.right = c;
    return right_part;
  }
  void merge(Interval& a, const Interval& b, std::size_t i) {
    const std::uint32_t c = corner(i);
    next_[a.right] = c;
    next_[c] = b.left;
    a.right = b.right;
  }

 private:
  std::uint32_t corner(std::size_t i) {
    const auto vertex = static_cast<std::uint32_t>(i);
    if (vertex != last_) return last_ = vertex;
    second_.push_back(vertex);
    next_.push_back(kNone);
    return static_cast<std::uint32_t>(next_.size() - 1);
  }

  std::size_t vertices_;
  std::uint32_t last_ = kNone;  // the vertex of the last corner
  Array<std::uint32_t> next_;
  std::vector<std::uint32_t> second_;  // vertices of second corners
  Array<Beginning> beginnings_;        // in order of their vertices
};

/// The x of vertices as small numbers in the same order: ordinals, or ranks where the ordinals are too
/// sparse.
class Columns {
 public:
  explicit Columns(const Contour& contour)
      : vertices_(contour.vertices), count_(contour.axes[0].count() + 1) {
    constexpr std::size_t kFew = 1 << 16;
    if (count_ <= std::max(kFew, vertices_.size())) return;
    Array<std::uint64_t> sorted(vertices_.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = std::uint64_t{vertices_[i].x} << 32 | i;
    radix_sort(std::span(sorted));
    ranks_.resize(sorted.size());
    count_ = 0;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      if (i == 0 || sorted[i] >> 32 != sorted[i - 1] >> 32) ++count_;
      ranks_[static_cast<std::uint32_t>(sorted[i])] = static_cast<std::uint32_t>(count_ - 1);
    }
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(count_); }
  std::uint32_t operator[](std::size_t vertex) const {
    return ranks_.empty() ? vertices_[vertex].x : ranks_[vertex];
  }

 private:
  std::span<const ContourVertex> vertices_;
  std::size_t count_;
  Array<std::uint32_t> ranks_;
};

/// The loops in the order of their beginnings, and the polygon of each.
struct Loops {
  Array<std::uint32_t> points, first_point = {0};
  Array<std::uint32_t> polygon;
  std::uint32_t polygons = 0;

  std::size_t size() const { return polygon.size(); }
};

/// Follows the links; afterwards they hold the loop of each corner.
Loops trace(LoopLinks& links) {
  Loops loops;
  with_memory("the loops", links.corners() * sizeof(std::uint32_t),
              [&] { loops.points.resize(links.corners()); });
  loops.first_point.reserve(links.beginnings().size() + 1);
  loops.polygon.reserve(links.beginnings().size());
  std::vector<std::uint64_t> traced(links.corners() / 64 + 1);
  std::uint32_t end = 0;
  for (const LoopLinks::Beginning& beginning : links.beginnings()) {
    std::uint32_t corner = beginning.corner;
    if (traced[corner / 64] >> corner % 64 & 1) continue;
    const auto loop = static_cast<std::uint32_t>(loops.size());
    do {
      loops.points[end++] = links.vertex(corner);
      traced[corner / 64] |= std::uint64_t{1} << corner % 64;
      corner = std::exchange(links.next(corner), loop);
    } while (corner != beginning.corner);
    loops.first_point.push_back(end);
    loops.polygon.push_back(beginning.beside == kNone ? loops.polygons++
                                                      : loops.polygon[links.next(beginning.beside)]);
  }
  return loops;
}

/// The loops sorted by polygon.
Faces sorted(Loops loops) {
  Faces faces;
  faces.direction.resize(loops.polygons);
  std::ranges::fill(faces.direction, kUp);
  faces.first_loop.resize(std::size_t{loops.polygons} + 1);
  if (loops.size() == loops.polygons) {  // no holes
    std::iota(faces.first_loop.begin(), faces.first_loop.end(), 0u);
    faces.loop_points = std::move(loops.points);
    faces.first_point = std::move(loops.first_point);
    return faces;
  }
  std::ranges::fill(faces.first_loop, 0u);
  for (const std::uint32_t polygon : loops.polygon) ++faces.first_loop[polygon + 1];
  std::inclusive_scan(faces.first_loop.begin(), faces.first_loop.end(), faces.first_loop.begin());
  std::vector<std::uint32_t> place(faces.first_loop.begin(), faces.first_loop.end() - 1), order(loops.size());
  for (std::uint32_t loop = 0; loop < order.size(); ++loop) order[place[loops.polygon[loop]]++] = loop;
  faces.first_point.resize(loops.size() + 1);
  for (std::size_t i = 0; i < order.size(); ++i)
    faces.first_point[i + 1] =
        faces.first_point[i] + loops.first_point[order[i] + 1] - loops.first_point[order[i]];
  with_memory("the polygons", loops.points.size() * sizeof(std::uint32_t),
              [&] { faces.loop_points.resize(loops.points.size()); });
  parallel_ranges(0, order.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      std::copy(loops.points.begin() + loops.first_point[order[i]],
                loops.points.begin() + loops.first_point[order[i] + 1],
                faces.loop_points.begin() + faces.first_point[i]);
  });
  return faces;
}

}  // namespace

Faces find_polygons(const Contour& contour) {
  const std::span<const ContourVertex> vertices = contour.vertices;
  if (vertices.size() >= kNone / 2)  // a vertex may have two corners
    throw Error(ErrorKind::resources, "the contour has more than 2^31 - 1 vertices");
  const Columns columns(contour);
  const auto swept = std::views::iota(std::uint32_t{0}, static_cast<std::uint32_t>(vertices.size())) |
                     std::views::transform([&](std::uint32_t i) {
                       return SweepVertex{i, columns[i], vertices[i].quadrants};
                     });
  LoopLinks links(vertices.size());
  FaceSweep<LoopLinks::Interval>().run(swept, columns.count(), links);
  Interruptible::check();
  return sorted(trace(links));
}

}  // namespace boxunion

#include "core/triangulation.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/face_sweep.hpp"
#include "core/memory.hpp"
#include "core/orientation.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kGrain = 1 << 10;  // faces
constexpr std::uint32_t kNone = Points::kNone;

/// Where a loop passes a point, seen so that loops run counter-clockwise.
struct Corner {
  std::array<double, 2> at;
  std::uint32_t point;
  std::uint32_t column;
  std::uint8_t quadrants;  // which the face fills
};

/// The direction of an edge: 0 right, 1 up, 2 left, 3 down.
unsigned direction(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  const unsigned vertical = from[0] == to[0];
  return 2 * unsigned(from[vertical] > to[vertical]) + vertical;
}

/// The quadrants to the left of a loop, by the directions in which it comes to a point and leaves it.
constexpr auto kQuadrantsLeft = [] {
  constexpr std::array<Quadrant, 4> counter_clockwise = {right_above, left_above, left_below, right_below};
  std::array<std::array<std::uint8_t, 4>, 4> quadrants{};
  for (unsigned in = 0; in < 4; ++in)
    for (unsigned out = 0; out < 4; ++out)
      for (unsigned k = out;; k = (k + 1) % 4) {
        quadrants[in][out] = std::uint8_t(quadrants[in][out] | 1u << counter_clockwise[k]);
        if (k == (in + 1) % 4) break;
      }
  return quadrants;
}();

/// Triangulates the faces of a sweep as it goes (Hertel and Mehlhorn, Fast triangulation of simple polygons,
/// 1983).
///
/// Below an interval everything is cut off but a chain from the lower point of its left end to that of its
/// right end, which turns clockwise or straight on everywhere. A new point sees the chain's end next to it,
/// or, if it splits the interval, the highest point of the chain, which is the last one that came.
class Chains {
 public:
  struct Interval {
    std::uint32_t left, right, last;  // nodes
  };

  /// From now on triangles of the corners' points go to `out`; `mirrored` ones have the opposite orientation.
  void reset(std::span<const Corner> corners, bool mirrored, Triangle* out) {
    corners_ = corners;
    mirrored_ = mirrored;
    out_ = out;
    nodes_.clear();
  }

  Interval start(std::size_t i) {
    const std::uint32_t n = add(i);
    return {n, n, n};
  }
  void end(Interval& a, std::size_t i) { append(a.right, add(i)); }
  void left(Interval& a, std::size_t i) { a.left = a.last = prepend(add(i), a.left); }
  void right(Interval& a, std::size_t i) { a.right = a.last = append(a.right, add(i)); }
  Interval split(Interval& a, std::size_t i) {
    // The chain is cut at its last node, which becomes the end of both parts.
    const std::uint32_t last = a.last, copy = add(nodes_[last].corner);
    Interval right_part = {copy, a.right == last ? copy : a.right, copy};
    link(copy, nodes_[last].next);
    nodes_[last].next = kNone;
    a.right = a.last = append(last, add(i));
    right_part.left = right_part.last = prepend(add(i), copy);
    return right_part;
  }
  void merge(Interval& a, const Interval& b, std::size_t i) {
    a.last = prepend(append(a.right, add(i)), b.left);
    a.right = b.right;
  }

 private:
  struct Node {
    std::uint32_t corner, previous, next;
  };

  std::uint32_t add(std::size_t corner) {
    nodes_.push_back({static_cast<std::uint32_t>(corner), kNone, kNone});
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  void link(std::uint32_t a, std::uint32_t b) {
    if (a != kNone) nodes_[a].next = b;
    if (b != kNone) nodes_[b].previous = a;
  }
  /// Puts node n at the right end of a chain that ends in b, or at the left end of one that begins with b,
  /// and cuts off what it sees. Returns n.
  std::uint32_t append(std::uint32_t b, std::uint32_t n) {
    for (std::uint32_t a; (a = nodes_[b].previous) != kNone && cut(a, b, n);) b = a;
    link(b, n);
    return n;
  }
  std::uint32_t prepend(std::uint32_t n, std::uint32_t b) {
    for (std::uint32_t c; (c = nodes_[b].next) != kNone && cut(n, b, c);) b = c;
    link(n, b);
    return n;
  }
  /// Cuts off the triangle of three nodes if they turn counter-clockwise.
  bool cut(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Corner &p = corner(a), &q = corner(b), &r = corner(c);
    if (orientation(p.at, q.at, r.at) <= 0) return false;
    *out_++ = mirrored_ ? Triangle{p.point, r.point, q.point} : Triangle{p.point, q.point, r.point};
    return true;
  }
  const Corner& corner(std::uint32_t node) const { return corners_[nodes_[node].corner]; }

  std::span<const Corner> corners_;
  bool mirrored_ = false;
  Triangle* out_ = nullptr;
  std::vector<Node> nodes_;
};

/// Triangulates one face at a time.
class FaceTriangulator {
 public:
  FaceTriangulator(std::span<const Point> points, const Faces& faces) : points_(points), faces_(&faces) {}

  void triangulate(std::size_t face, Triangle* out) {
    const std::uint32_t outer = faces_->first_loop[face], end = faces_->first_loop[face + 1];
    const auto loop = faces_->loop(outer);
    if (end == outer + 1 && loop.size() == 4) {  // a rectangle
      out[0] = {loop[0], loop[1], loop[2]};
      out[1] = {loop[2], loop[3], loop[0]};
      return;
    }
    const unsigned direction = faces_->direction[face];
    const bool mirrored = direction % 2 == 1;
    corners_.clear();
    for (std::uint32_t l = outer; l < end; ++l) add_loop(l, direction / 2, mirrored);
    const std::uint32_t columns = rank_columns();
    std::ranges::sort(corners_, [](const Corner& a, const Corner& b) {
      if (a.at[1] != b.at[1]) return a.at[1] < b.at[1];
      if (a.column != b.column) return a.column < b.column;
      return a.quadrants < b.quadrants;  // an end before a start
    });
    chains_.reset(corners_, mirrored, out);
    sweep_.run(
        corners_.size(), columns, [&](std::size_t i) { return corners_[i].column; },
        [&](std::size_t i) { return corners_[i].quadrants; }, chains_);
  }

 private:
  void add_loop(std::uint32_t l, unsigned axis, bool mirrored) {
    const auto loop = faces_->loop(l);
    const auto at = [&](std::size_t i) {
      const Point& p = points_[loop[mirrored ? loop.size() - 1 - i : i]];
      return std::array{p[(axis + 1) % 3], p[(axis + 2) % 3]};
    };
    std::array here = at(0);
    unsigned in = direction(at(loop.size() - 1), here);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::array next = at(i + 1 < loop.size() ? i + 1 : 0);
      const unsigned out = direction(here, next);
      corners_.push_back({here, loop[mirrored ? loop.size() - 1 - i : i], 0, kQuadrantsLeft[in][out]});
      here = next;
      in = out;
    }
  }

  /// Gives every corner its column; returns how many there are.
  std::uint32_t rank_columns() {
    columns_.clear();
    for (const Corner& corner : corners_) columns_.push_back(corner.at[0]);
    std::ranges::sort(columns_);
    columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
    for (Corner& corner : corners_)
      corner.column =
          static_cast<std::uint32_t>(std::ranges::lower_bound(columns_, corner.at[0]) - columns_.begin());
    return static_cast<std::uint32_t>(columns_.size());
  }

  std::span<const Point> points_;
  const Faces* faces_;
  std::vector<Corner> corners_;
  std::vector<double> columns_;
  FaceSweep<Chains::Interval> sweep_;
  Chains chains_;
};

}  // namespace

Triangulation triangulate(std::span<const Point> points, const Faces& faces) {
  const std::size_t count = faces.loop_points.size() + 2 * faces.holes() - 2 * faces.size();
  if (count > kNone) throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 1 triangles");
  Triangulation result;
  with_memory("the triangles of the boundary", count * sizeof(Triangle), [&] {
    result.triangles.resize(count);
    result.first.resize(faces.size() + 1);
  });
  // Every face's n + 2 * holes - 2 come after those of the faces before it.
  parallel_ranges(0, faces.size() + 1, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const std::size_t loops = faces.first_loop[f];
      result.first[f] = static_cast<std::uint32_t>(faces.first_point[loops] + 2 * (loops - f) - 2 * f);
    }
  });
  PerThread<FaceTriangulator> triangulators(FaceTriangulator(points, faces));
  parallel_ranges(0, faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    FaceTriangulator& triangulator = triangulators.local();
    for (std::size_t f = begin; f < end; ++f)
      triangulator.triangulate(f, result.triangles.data() + result.first[f]);
  });
  return result;
}

Mesh make_mesh(const Solid& solid, NonManifold contacts) {
  const Planes planes = make_planes(solid);
  const Points points(solid, planes, contacts);
  Mesh mesh;
  mesh.points = points.positions();
  mesh.triangles = triangulate(mesh.points, find_faces(solid, planes, points)).triangles;
  return mesh;
}

}  // namespace boxunion

#include <algorithm>
#include <numeric>

#include "boxunion/error.hpp"
#include "boxunion/mesh.hpp"
#include "core/base/memory.hpp"
#include "core/boundary/face_sweep.hpp"
#include "core/boundary/faces.hpp"
#include "core/boundary/orientation.hpp"
#include "core/boundary/plane_sweep.hpp"
#include "core/boundary/points.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kTriangulatedGrain = 1 << 10;  // faces
constexpr std::uint32_t kNone = Points::kNone;

[[noreturn]] void throw_too_many() {
  throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 1 triangles");
}

/// The position of a corner of a face, seen so that the outer loop runs counter-clockwise.
struct Corner {
  std::array<double, 2> at;
  std::uint32_t point;
};

/// The direction of an edge: 0 right, 1 up, 2 left, 3 down.
unsigned direction(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  const unsigned vertical = from[0] == to[0];
  return 2 * unsigned(from[vertical] > to[vertical]) + vertical;
}

/// The quadrants to the left of a loop, by the directions in which the loop reaches and leaves a point.
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

/// A corner on a chain; see Chains.
struct ChainNode {
  Corner corner;
  std::uint32_t previous, next;
};
struct ChainInterval {
  std::uint32_t left, right, last;  // nodes
};

/// Triangulates the faces of a sweep on the way (Hertel and Mehlhorn, Fast triangulation of simple polygons,
/// 1983). corner(i, quadrant) is the corner of a face at vertex i of the sweep that fills a quadrant there.
///
/// Below an interval, everything is cut off except a chain from the lower point of its left end to that of
/// its right end. The chain turns clockwise or goes straight on everywhere. A new point sees the end of the
/// chain next to it. If it splits the interval, it sees the highest point of the chain, which is the last one
/// that came.
template <class CornerOf>
class Chains {
 public:
  using Interval = ChainInterval;

  /// Triangles go to `out`; `mirrored` ones have the opposite orientation.
  Chains(std::vector<ChainNode>& nodes, CornerOf corner, bool mirrored, Triangle* out)
      : nodes_(nodes), corner_(corner), mirrored_(mirrored), out_(out) {
    nodes_.clear();
  }
  /// The end of the triangles written so far.
  Triangle* out() const { return out_; }

  Interval start(std::size_t i) {
    const std::uint32_t n = add(i, right_above);
    return {n, n, n};
  }
  void end(Interval& a, std::size_t i) { append(a.right, add(i, left_below)); }
  void left(Interval& a, std::size_t i) { a.left = a.last = prepend(add(i, right_below), a.left); }
  void right(Interval& a, std::size_t i) { a.right = a.last = append(a.right, add(i, left_above)); }
  Interval split(Interval& a, std::size_t i) {
    // Split the chain at its last node, which becomes the end of both parts.
    const std::uint32_t last = a.last, copy = add(nodes_[last].corner);
    Interval right_part = {copy, a.right == last ? copy : a.right, copy};
    link(copy, nodes_[last].next);
    nodes_[last].next = kNone;
    a.right = a.last = append(last, add(i, left_above));
    right_part.left = right_part.last = prepend(add(i, left_above), copy);
    return right_part;
  }
  void merge(Interval& a, const Interval& b, std::size_t i) {
    a.last = prepend(append(a.right, add(i, left_above)), b.left);
    a.right = b.right;
  }

 private:
  std::uint32_t add(std::size_t i, Quadrant quadrant) { return add(corner_(i, quadrant)); }
  std::uint32_t add(const Corner& corner) {
    nodes_.push_back({corner, kNone, kNone});
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  void link(std::uint32_t a, std::uint32_t b) {
    if (a != kNone) nodes_[a].next = b;
    if (b != kNone) nodes_[b].previous = a;
  }
  /// Appends node n to the right end of a chain that ends in b, or to the left end of a chain that begins
  /// with b. Cuts off the triangles that n sees. Returns n.
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
  /// Cuts off the triangle of three nodes if they turn counter-clockwise, and returns whether it did.
  bool cut(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Corner &p = nodes_[a].corner, &q = nodes_[b].corner, &r = nodes_[c].corner;
    if (orientation(p.at, q.at, r.at) <= 0) return false;
    *out_++ = mirrored_ ? Triangle{p.point, r.point, q.point} : Triangle{p.point, q.point, r.point};
    return true;
  }

  std::vector<ChainNode>& nodes_;
  CornerOf corner_;
  bool mirrored_;
  Triangle* out_;
};

/// Triangulates one face at a time.
class FaceTriangulator {
 public:
  FaceTriangulator(std::span<const Point> points, const Faces& faces) : points_(points), faces_(&faces) {}

  void triangulate(std::size_t face, Triangle* out) {
    const std::uint32_t outer = faces_->first_loop[face], end = faces_->first_loop[face + 1];
    const auto loop = faces_->loop(outer);
    const unsigned direction = faces_->direction[face];
    const bool mirrored = direction % 2 == 1;
    if (end == outer + 1 && loop.size() == 4) {  // a rectangle, cut as in Chains
      const unsigned m = mirrored;
      out[0] = {loop[3 - 2 * m], loop[3 * m], loop[1 - m]};
      out[1] = {loop[3 - 2 * m], loop[1 + m], loop[2 + m]};
      return;
    }
    corners_.clear();
    for (std::uint32_t l = outer; l < end; ++l) add_loop(l, direction / 2, mirrored);
    const std::uint32_t columns = rank_columns();
    std::ranges::sort(corners_, [](const LoopCorner& a, const LoopCorner& b) {
      if (a.at[1] != b.at[1]) return a.at[1] < b.at[1];
      if (a.column != b.column) return a.column < b.column;
      return a.quadrants < b.quadrants;  // ends come before starts
    });
    swept_.clear();
    for (const LoopCorner& corner : corners_)
      swept_.push_back({static_cast<std::uint32_t>(swept_.size()), corner.column, corner.quadrants});
    sweep_.run(
        swept_, columns,
        Chains(
            nodes_, [&](std::size_t i, Quadrant) -> const Corner& { return corners_[i]; }, mirrored, out));
  }

 private:
  struct LoopCorner : Corner {
    std::uint32_t column;
    std::uint8_t quadrants;  // filled by the face
  };

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
      corners_.push_back({{here, loop[mirrored ? loop.size() - 1 - i : i]}, 0, kQuadrantsLeft[in][out]});
      here = next;
      in = out;
    }
  }

  /// Gives every corner its column, and returns the number of columns.
  std::uint32_t rank_columns() {
    columns_.clear();
    for (const LoopCorner& corner : corners_) columns_.push_back(corner.at[0]);
    std::ranges::sort(columns_);
    columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
    for (LoopCorner& corner : corners_)
      corner.column =
          static_cast<std::uint32_t>(std::ranges::lower_bound(columns_, corner.at[0]) - columns_.begin());
    return static_cast<std::uint32_t>(columns_.size());
  }

  std::span<const Point> points_;
  const Faces* faces_;
  std::vector<LoopCorner> corners_;
  std::vector<double> columns_;
  std::vector<SweepVertex> swept_;
  FaceSweep<ChainInterval> sweep_;
  std::vector<ChainNode> nodes_;
};

/// Triangulates the faces of one plane at a time, first those of one direction, then those of the other.
class PlaneTriangulator {
 public:
  PlaneTriangulator(const Axes& axes, const Points& points)
      : coordinates_{Coordinates(axes[0]), Coordinates(axes[1]), Coordinates(axes[2])}, points_(&points) {}

  /// Returns the end of the triangles.
  Triangle* triangulate(int axis, std::span<const PlaneVertex> plane, Triangle* out) {
    const Coordinates &column = coordinates_[unsigned(axis + 1) % 3],
                      &row = coordinates_[unsigned(axis + 2) % 3];
    sweep_.assign(axis, plane);
    for (unsigned side = 0; side < 2; ++side) {
      if (sweep_.is_rectangle(side)) {
        out = cut_rectangle(axis, side, plane, out);
        continue;
      }
      Chains chains(
          nodes_,
          [&](std::size_t i, Quadrant quadrant) {
            const PlaneVertex& v = plane[i];
            return Corner{{column(v.column), row(v.row)},
                          points_->at(v, octant_at(axis, side, quadrant), axis)};
          },
          side == 1, out);
      sweep_.run(side, chains);
      out = chains.out();
    }
    return out;
  }

 private:
  /// Cuts a rectangle as Chains would.
  Triangle* cut_rectangle(int axis, unsigned side, std::span<const PlaneVertex> plane, Triangle* out) const {
    constexpr std::array<Quadrant, 4> inside = {right_above, left_above, right_below, left_below};
    std::array<std::uint32_t, 4> p;
    for (unsigned i = 0; i < 4; ++i)
      p[i] = points_->at(plane[sweep_.vertices(side)[i].id], octant_at(axis, side, inside[i]), axis);
    *out++ = {p[2], p[side], p[1 - side]};
    *out++ = {p[2], p[1 + 2 * side], p[3 - 2 * side]};
    return out;
  }

  std::array<Coordinates, 3> coordinates_;
  const Points* points_;
  PlaneSweep<ChainInterval> sweep_;
  std::vector<ChainNode> nodes_;
};

/// The number of triangles of the faces of some planes normal to an axis.
std::size_t count_triangles(int axis, std::span<const PlaneVertex> vertices) {
  std::size_t filled = 0;
  for (const PlaneVertex& v : vertices) filled += kFilledQuadrants[std::size_t(axis)][v.mask];
  return filled / 2;
}

}  // namespace

Triangulation triangulate(std::span<const Point> points, const Faces& faces) {
  const std::size_t count = faces.loop_points.size() + 2 * faces.holes() - 2 * faces.size();
  if (count > kNone) throw_too_many();
  Triangulation result;
  with_memory("the triangles of the boundary", count * sizeof(Triangle), [&] {
    result.triangles.resize(count);
    result.first.resize(faces.size() + 1);
  });
  // The n + 2 * holes - 2 triangles of a face come after those of the faces before it.
  parallel_for_each(0, faces.size() + 1, kTriangulatedGrain, [&](std::size_t f) {
    const std::size_t loops = faces.first_loop[f];
    result.first[f] = static_cast<std::uint32_t>(faces.first_point[loops] + 2 * (loops - f) - 2 * f);
  });
  PerThread<FaceTriangulator> triangulators(FaceTriangulator(points, faces));
  parallel_ranges(0, faces.size(), kTriangulatedGrain, [&](std::size_t begin, std::size_t end) {
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
  if (points.has_midpoints()) {  // these lie between the rows and columns of a plane
    mesh.triangles = triangulate(mesh.points, find_faces(planes, points)).triangles;
    return mesh;
  }
  const std::vector<PlaneChunk> chunks = cut_into_chunks(planes);
  std::vector<std::size_t> first(chunks.size() + 1);
  parallel_for_each(0, chunks.size(), 1, [&](std::size_t i) {
    first[i + 1] = count_triangles(chunks[i].axis, planes[chunks[i].axis].vertices_of(chunks[i]));
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  if (first.back() > kNone) throw_too_many();
  with_memory("the triangles of the boundary", first.back() * sizeof(Triangle),
              [&] { mesh.triangles.resize(first.back()); });
  PerThread<PlaneTriangulator> triangulators(PlaneTriangulator(solid.axes, points));
  parallel_ranges(0, chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
    PlaneTriangulator& triangulator = triangulators.local();
    for (std::size_t i = begin; i < end; ++i) {
      Triangle* out = mesh.triangles.data() + first[i];
      const PlaneOrder& order = planes[chunks[i].axis];
      for (std::size_t p = chunks[i].begin; p < chunks[i].end; ++p)
        out = triangulator.triangulate(chunks[i].axis, order.plane(p), out);
    }
  });
  return mesh;
}

}  // namespace boxunion

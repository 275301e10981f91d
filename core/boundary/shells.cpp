#include "core/boundary/shells.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/boundary/faces.hpp"
#include "core/boundary/plane_sweep.hpp"
#include "core/boundary/shell_joins.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kFaceGrain = 1 << 11;  // faces

/// A rectangle of the y-z plane, lo <= p < hi.
struct Rectangle {
  std::array<std::uint32_t, 2> lo, hi;
};

/// Points of the y-z plane over which walls are painted, to find the last wall over each point. A k-d tree,
/// in which a node paints all of its points at once. Later walls have higher tags, so the last wall over a
/// point is the highest one.
class PaintedPoints {
 public:
  using Point = std::array<std::uint32_t, 2>;

  explicit PaintedPoints(std::span<const Point> points) : nodes_(points.size()), places_(points.size()) {
    for (std::uint32_t i = 0; i < points.size(); ++i) nodes_[i] = {points[i], i};
    build(0, nodes_.size(), 0);
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) places_[nodes_[i].name] = i;
  }

  /// Paints a wall. Tags ascend from 1.
  void paint(const Rectangle& wall, std::uint32_t tag) {
    paint(wall, tag, 0, nodes_.size(), 0, {{0, 0}, {Axis::kOrdinalMax, Axis::kOrdinalMax}});
  }

  /// The tag of the last wall over a point, or 0. `point` is its position in the list of the constructor.
  std::uint32_t last(std::size_t point) const {
    const std::size_t place = places_[point];
    std::uint32_t tag = nodes_[place].own_tag;
    for (std::size_t first = 0, last = nodes_.size(); first < last;) {
      const std::size_t middle = (first + last) / 2;
      tag = std::max(tag, nodes_[middle].tag);
      if (place == middle) break;
      (place < middle ? last : first) = place < middle ? middle : middle + 1;
    }
    return tag;
  }

 private:
  struct Node {
    Point at;
    std::uint32_t name;
    std::uint32_t tag = 0, own_tag = 0;  // of all points of the subtree, and of this point
  };

  void build(std::size_t first, std::size_t last, unsigned axis) {
    if (last - first < 2) return;
    const std::size_t middle = (first + last) / 2;
    const auto at = [&](std::size_t i) { return nodes_.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(first), at(middle), at(last),
                     [axis](const Node& a, const Node& b) { return a.at[axis] < b.at[axis]; });
    build(first, middle, 1 - axis);
    build(middle + 1, last, 1 - axis);
  }

  /// `all` holds the points first .. last - 1, including those on its upper sides.
  void paint(const Rectangle& wall, std::uint32_t tag, std::size_t first, std::size_t last, unsigned axis,
             const Rectangle& all) {
    if (first == last) return;
    bool inside = true;
    for (int a = 0; a < 2; ++a) {
      if (all.hi[a] < wall.lo[a] || wall.hi[a] <= all.lo[a]) return;
      inside &= wall.lo[a] <= all.lo[a] && all.hi[a] < wall.hi[a];
    }
    const std::size_t middle = (first + last) / 2;
    Node& node = nodes_[middle];
    if (inside) {
      node.tag = tag;
      return;
    }
    if (wall.lo[0] <= node.at[0] && node.at[0] < wall.hi[0] && wall.lo[1] <= node.at[1] &&
        node.at[1] < wall.hi[1])
      node.own_tag = tag;
    Rectangle lower = all, upper = all;
    lower.hi[axis] = upper.lo[axis] = node.at[axis];
    paint(wall, tag, first, middle, 1 - axis, lower);
    paint(wall, tag, middle + 1, last, 1 - axis, upper);
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> places_;
};

/// Cuts the faces of a plane towards -x into rectangles. Calls f(rectangle, fan) for each, with a fan of the
/// face.
template <class F>
class Walls {
 public:
  struct Interval {
    std::uint32_t left, right, since;  // columns (y), and the row (z) from which on they hold
    std::uint32_t fan;
  };

  Walls(const Fans& fans, std::span<const PlaneVertex> plane, F& f) : fans_(fans), plane_(plane), f_(f) {}

  Interval start(std::size_t i) {
    const PlaneVertex& v = plane_[i];
    return {v.column, v.column, v.row, fans_.at(v, octant_at(0, 1, right_above), 0)};
  }
  void end(Interval& a, std::size_t i) { close(a, i); }
  void left(Interval& a, std::size_t i) {
    close(a, i);
    a.left = plane_[i].column;
  }
  void right(Interval& a, std::size_t i) {
    close(a, i);
    a.right = plane_[i].column;
  }
  Interval split(Interval& a, std::size_t i) {
    close(a, i);
    Interval right_part = a;
    right_part.left = a.right = plane_[i].column;
    return right_part;
  }
  void merge(Interval& a, Interval& b, std::size_t i) {
    close(a, i);
    close(b, i);
    a.right = b.right;
  }

 private:
  void close(Interval& a, std::size_t i) {
    const std::uint32_t row = plane_[i].row;
    if (a.since < row) f_(Rectangle{{a.left, a.since}, {a.right, row}}, a.fan);
    a.since = row;
  }

  const Fans& fans_;
  std::span<const PlaneVertex> plane_;
  F& f_;
};

/// For each of some points inside the solid: a fan of the wall that a ray in direction -x meets. The points
/// lie just above the vertices on y and z.
std::vector<std::uint32_t> fans_left_of(const Solid& solid, const PlaneOrder& planes, const Fans& fans,
                                        std::span<const std::uint32_t> vertices) {
  std::vector<PaintedPoints::Point> points(vertices.size());
  std::vector<std::uint32_t> by_x(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    points[i] = {solid.vertices[vertices[i]].y, solid.vertices[vertices[i]].z};
    by_x[i] = i;
  }
  const auto x_of = [&](std::uint32_t i) { return solid.vertices[vertices[i]].x; };
  std::ranges::sort(by_x, {}, x_of);

  PaintedPoints painted(points);
  std::vector<std::uint32_t> painters, found(vertices.size());
  const auto paint = [&](const Rectangle& wall, std::uint32_t fan) {
    painters.push_back(fan);
    painted.paint(wall, static_cast<std::uint32_t>(painters.size()));
  };
  PlaneSweep<Walls<decltype(paint)>::Interval> sweep;
  auto next = by_x.begin();
  for (std::size_t p = 0; p < planes.planes(); ++p) {
    const std::span<const PlaneVertex> plane = planes.plane(p);
    for (; next != by_x.end() && x_of(*next) <= solid.vertices[plane[0].vertex].x; ++next)
      found[*next] = painters[painted.last(*next) - 1];
    sweep.assign(0, plane);
    sweep.run(1, Walls(fans, plane, paint));
  }
  return found;
}

}  // namespace

Shells find_shells(const Solid& solid, const Planes& planes, const Faces& faces, NonManifold contacts) {
  const Fans fans(solid);
  DisjointSets sets(fans.count(), "joining faces");
  join_shells(solid, planes, fans, faces, contacts,
              [&](std::uint32_t a, std::uint32_t b) { sets.join(a, b); });

  // At the lowest vertex of a shell, all edges lead upwards. Either the octant above is filled, and the shell
  // encloses its body; or this octant is empty, its three neighbors are filled, and the shell encloses a
  // cavity.
  Shells shells;
  Array<std::uint32_t> shell_of(fans.count());  // by the lowest fan of each shell
  std::vector<std::uint32_t> cavity_vertices, cavity_shells;
  for (std::uint32_t fan = 0; fan < fans.count(); ++fan) {
    if (!sets.is_lowest(fan)) continue;
    const std::uint32_t vertex = fans.vertex(fan);
    shell_of[fan] = static_cast<std::uint32_t>(shells.cavity.size());
    const bool cavity = !(solid.vertices[vertex].mask >> 7 & 1u);
    if (cavity) {
      cavity_vertices.push_back(vertex);
      cavity_shells.push_back(shell_of[fan]);
    }
    shells.cavity.push_back(cavity);
    shells.bodies += !cavity;
  }
  shells.of_face.resize(faces.size());
  parallel_for_each(0, faces.size(), kFaceGrain, [&](std::size_t face) {
    shells.of_face[face] =
        shell_of[sets.find(fan_of_loop(solid, fans, faces, contacts, face, faces.first_loop[face]))];
  });

  // From there, a ray towards -x runs inside the body until it meets a shell that begins lower.
  shells.body.resize(shells.cavity.size());
  std::uint32_t bodies = 0;
  for (std::size_t shell = 0; shell < shells.body.size(); ++shell)
    if (!shells.cavity[shell]) shells.body[shell] = bodies++;
  if (bodies > 1 && !cavity_shells.empty()) {
    const std::vector<std::uint32_t> met = fans_left_of(solid, planes[0], fans, cavity_vertices);
    for (std::size_t i = 0; i < met.size(); ++i)
      shells.body[cavity_shells[i]] = shells.body[shell_of[sets.find(met[i])]];
  }
  return shells;
}

}  // namespace boxunion

#include "host/external/external_boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/mesh.hpp"
#include "core/base/disjoint_sets.hpp"
#include "core/base/radix_sort.hpp"
#include "core/boundary/faces.hpp"
#include "core/boundary/shell_joins.hpp"
#include "core/models/sections.hpp"
#include "core/solid/fans.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/external/sorted_runs.hpp"

namespace boxunion {
namespace {

constexpr std::uint64_t kMostNumbers = 0xfffffffeu;  // maximum number of points
constexpr std::size_t kPartVertices = 1 << 18;       // of planes that are processed together, if they fit
constexpr std::size_t kVertexBytes = 256;            // maximum memory for such a vertex

/// A vertex with its number among all vertices and the number of its first fan.
template <class C>
struct NumberedVertex {
  std::array<C, 3> at;
  C mask;
  std::uint32_t number, fan;
};

/// The order of vertices by planes along an axis, rows and columns, as in PlaneOrder.
struct ByPlane {
  unsigned axis = 2;

  template <class V>
  bool operator()(const V& a, const V& b) const {
    for (const unsigned k : {0u, 2u, 1u}) {
      const unsigned c = (axis + k) % 3;
      if (a.at[c] != b.at[c]) return a.at[c] < b.at[c];
    }
    return false;
  }
};

/// Sets the ordinals of a part. On lattices they are those of the whole, otherwise ranks within the part.
void set_ordinals(std::span<const NumberedVertex<std::uint32_t>> vertices, const Axes& axes, Solid& part) {
  part.axes = axes;
  for (const auto& v : vertices) part.vertices.push_back({v.at[0], v.at[1], v.at[2], v.mask});
}
void set_ordinals(std::span<const NumberedVertex<std::uint64_t>> vertices, const Axes&, Solid& part) {
  part.vertices.resize(vertices.size());
  std::vector<std::uint64_t> distinct;
  for (unsigned a = 0; a < 3; ++a) {
    distinct.clear();
    for (const auto& v : vertices) distinct.push_back(v.at[a]);
    radix_sort(std::span(distinct));
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    std::vector<double> coordinates(distinct.size());
    std::ranges::transform(distinct, coordinates.begin(), from_ordered_bits);
    part.axes[a] = Axis::rank(std::move(coordinates));
    parallel_for_each(0, vertices.size(), 1 << 14, [&](std::size_t i) {
      const auto place = std::ranges::lower_bound(distinct, vertices[i].at[a]) - distinct.begin();
      Vertex& v = part.vertices[i];
      (a == 0 ? v.x : a == 1 ? v.y : v.z) = static_cast<std::uint32_t>(place + 1);
      v.mask = static_cast<std::uint32_t>(vertices[i].mask);
    });
  }
}

/// The planes of a part along `axis`. If contacts are split, also the planes along the axis of their rows,
/// for the edges there.
Planes planes_of(const Solid& part, int axis, NonManifold contacts) {
  const auto ordinal = [&](std::uint32_t vertex, int a) {
    const Vertex& v = part.vertices[vertex];
    return std::array{v.x, v.y, v.z}[std::size_t(a % 3)];
  };
  const auto count = static_cast<std::uint32_t>(part.vertices.size());
  Planes planes;
  for (PlaneOrder& order : planes) order.first = {0};
  PlaneOrder& own = planes[std::size_t(axis)];
  for (std::uint32_t i = 0; i < count; ++i) {
    own.vertices.push_back({i, ordinal(i, axis + 1), ordinal(i, axis + 2), part.vertices[i].mask});
    if (i > 0 && ordinal(i, axis) != ordinal(i - 1, axis)) own.first.push_back(i);
  }
  if (count > 0) own.first.push_back(count);
  if (contacts == NonManifold::split) {
    Array<PlaneVertex>& lines = planes[std::size_t(axis + 1) % 3].vertices;
    for (std::uint32_t i = 0; i < count; ++i)
      lines.push_back({i, ordinal(i, axis + 2), ordinal(i, axis), part.vertices[i].mask});
    radix_sort(std::span(lines), [&](const PlaneVertex& v) {
      return PointKey()(OrderedPoint<3>{v.row, ordinal(v.vertex, axis + 1), v.column});
    });
  }
  return planes;
}

template <class C>
class BoundaryRun {
 public:
  BoundaryRun(ExternalUnion& solid, NonManifold contacts, Report& report)
      : solid_(solid), contacts_(contacts), report_(report) {}

  ExternalBoundary run(bool triangles_only, OutputFile file) {
    // numbering, points, faces of three axes, shells; midpoints of three axes
    solid_.expect_passes(contacts_ == NonManifold::keep ? 6 : 9);
    collect();
    Stopwatch watch(report_);
    number();
    watch.lap("planes");
    VertexCounts& vertices = result_.vertices;
    BoundaryCounts& counts = result_.counts;
    counts.triangles = vertices.triangles() + 2 * midpoint_keys_.size();
    const std::uint64_t points = contacts_ == NonManifold::keep ? vertices.vertices : vertices.fans;
    if (std::max(vertices.fans, points + midpoint_keys_.size()) > kMostNumbers ||
        counts.triangles > kMostNumbers)
      throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 2 points or triangles");
    if (is_mesh(file.path())) {
      writer_ = begin_mesh(file, {points + midpoint_keys_.size(), counts.triangles, triangles_only});
      write_points();
    } else {
      write_vertices(file);
    }
    watch.lap("points");
    counts.shells_bytes = vertices.fans * sizeof(std::uint32_t);
    if (counts.shells_bytes <= solid_.bytes() / 2)
      shells_.emplace(static_cast<std::uint32_t>(vertices.fans), "joining faces");
    for (const int axis : {0, 1, 2}) add_planes(axis);
    watch.lap("faces");
    if (shells_) count_shells();
    watch.lap("shells");
    if (writer_) {
      writer_->finish();
      result_.exact = writer_->exact();
    }
    file.commit();
    watch.total();
    return result_;
  }

 private:
  using Numbered = NumberedVertex<C>;
  using Sorted = SortedRuns<ExternalVertex<C>>;
  using Runs = SortedRuns<Numbered, ByPlane>;
  struct Midpoint {
    std::uint64_t key;
    Point at;
    friend bool operator<(const Midpoint& a, const Midpoint& b) { return a.key < b.key; }
  };

  Point point_of(const Numbered& v) const {
    Point point;
    for (unsigned a = 0; a < 3; ++a) point[a] = external_coordinate(solid_.axes()[a], v.at[a]);
    return point;
  }

  void collect() {
    const std::uint64_t half = solid_.bytes() / 2;
    by_z_ = std::make_unique<Sorted>(half, thread_count(), solid_.scratch_file());
    solid_.unite<C>(half, [&](std::span<const ExternalVertex<C>> vertices) { by_z_->add(vertices); });
    if (by_z_->count() > kMostNumbers)
      throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 2 vertices");
  }

  /// Passes all vertices to f(span) in the order of the planes along an axis.
  void each_block(int axis, const std::function<void(std::span<const Numbered>)>& f) {
    const std::uint64_t bytes = solid_.bytes() / 8;
    const auto use = [&](std::span<const Numbered> block) {
      f(block);
      solid_.advance(block.size());
    };
    solid_.begin_pass(by_z_->count());
    if (axis != 2) return by_plane_[std::size_t(axis)]->merge(bytes, use);
    std::uint32_t number = 0, fan = 0;
    std::vector<Numbered> numbered;
    by_z_->merge(bytes, [&](std::span<const ExternalVertex<C>> block) {
      numbered.clear();
      for (const ExternalVertex<C>& v : block) {
        numbered.push_back({v.at, v.mask, number++, fan});
        fan += kFans[v.mask].count;
      }
      use(numbered);
    });
  }

  /// Numbers the vertices, sorts them by the planes of the other axes, and finds the midpoints.
  void number() {
    for (const unsigned axis : {0u, 1u})
      by_plane_[axis] = std::make_unique<Runs>(solid_.bytes() / 4, 1, solid_.scratch_file(), ByPlane{axis});
    each_block(2, [&](std::span<const Numbered> block) {
      for (const Numbered& v : block) result_.vertices.add(unsigned(v.mask));
      for (const auto& runs : by_plane_) runs->add(block);
    });
    for (const auto& runs : by_plane_) runs->finish();
    if (contacts_ == NonManifold::keep) return;
    midpoints_ = std::make_unique<SortedRuns<Midpoint>>(solid_.bytes() / 8, 1, solid_.scratch_file());
    for (const int axis : {2, 0, 1}) find_midpoints(axis);
    const std::uint64_t count = midpoints_->count();
    if (count * sizeof(std::uint64_t) > solid_.bytes() / 8)
      throw Error(ErrorKind::resources,
                  fmt::format("{} midpoints of split edges do not fit the budget: expected --memory of at "
                              "least {} MiB",
                              count, (solid_.budget_for(64 * count) >> 20) + 1));
    midpoint_keys_.reserve(count);
    midpoints_->merge(solid_.bytes() / 8, [&](std::span<const Midpoint> block) {
      for (const Midpoint& m : block) midpoint_keys_.push_back(m.key);
    });
  }

  /// Finds the midpoints along the rows of planes, where the ends of an edge are neighbors.
  void find_midpoints(int plane_axis) {
    const int axis = (plane_axis + 1) % 3;
    std::optional<Numbered> lower;
    each_block(plane_axis, [&](std::span<const Numbered> block) {
      for (const Numbered& v : block) {
        if (lower && kOctants[lower->mask].edges[2 * axis] == 2 &&
            needs_midpoint(unsigned(lower->mask), unsigned(v.mask), axis))
          midpoints_->add(
              Midpoint{Points::key(lower->number, axis), midpoint(point_of(*lower), point_of(v), axis)});
        lower = v;
      }
    });
  }

  void write_points() {
    if (!writer_->is_indexed()) return;
    std::vector<Point> points;
    each_block(2, [&](std::span<const Numbered> block) {
      points.clear();
      for (const Numbered& v : block)
        points.insert(points.end(), contacts_ == NonManifold::keep ? 1 : kFans[v.mask].count, point_of(v));
      writer_->write_points(points);
    });
    if (!midpoints_) return;
    midpoints_->merge(solid_.bytes() / 8, [&](std::span<const Midpoint> block) {
      points.clear();
      for (const Midpoint& m : block) points.push_back(m.at);
      writer_->write_points(points);
    });
  }

  void write_vertices(OutputFile& file) {
    VertexWriter writer(file, result_.vertices.vertices);
    std::vector<PlacedVertex> placed;
    each_block(2, [&](std::span<const Numbered> block) {
      placed.clear();
      for (const Numbered& v : block) placed.push_back({point_of(v), std::uint8_t(v.mask)});
      writer.write(placed);
    });
  }

  /// Finds the faces in the planes along an axis, as many planes at a time as fit.
  void add_planes(int axis) {
    const std::size_t most = solid_.bytes() / 4 / kVertexBytes, enough = std::min(kPartVertices, most / 2);
    std::vector<Numbered> part;
    std::size_t count = 0;  // vertices of the part and the next plane, even if they do not fit
    const auto finish = [&] {
      if (count > most)
        throw Error(ErrorKind::resources,
                    fmt::format("a plane of {} vertices does not fit the budget: expected --memory of at "
                                "least {} MiB",
                                count, (solid_.budget_for(4 * kVertexBytes * count) >> 20) + 1));
      add_part(axis, part);
      part.clear();
      count = 0;
    };
    C plane = 0;
    each_block(axis, [&](std::span<const Numbered> block) {
      for (const Numbered& v : block) {
        const C at = v.at[std::size_t(axis)];
        if (at != plane && count >= enough) finish();
        plane = at;
        if (++count <= most) part.push_back(v);
      }
    });
    if (count > 0) finish();
  }

  void add_part(int axis, std::span<const Numbered> vertices) {
    Solid part;
    set_ordinals(vertices, solid_.axes(), part);
    const Planes planes = planes_of(part, axis, contacts_);
    const Points points(part, planes, contacts_);
    Faces faces = find_faces(planes, points);
    result_.counts.faces += faces.size();
    result_.counts.holes += faces.holes();
    const std::vector<std::uint32_t> fans = fans_of(vertices);
    if (shells_)
      join_shells(part, planes, Fans(part), faces, contacts_,
                  [&](std::uint32_t a, std::uint32_t b) { shells_->join(fans[a], fans[b]); });
    if (!writer_) return;
    const Array<Point> positions = points.positions();
    Triangulation triangulation = triangulate(positions, faces);
    if (writer_->is_indexed()) {
      const std::vector<std::uint32_t> numbers = numbers_of(vertices, points, fans);
      const auto renumber = [&](std::uint32_t& point) { point = numbers[point]; };
      std::ranges::for_each(faces.loop_points, renumber);
      for (Triangle& triangle : triangulation.triangles) std::ranges::for_each(triangle, renumber);
    }
    writer_->write_faces(positions, faces, triangulation);
  }

  /// The numbers of all fans of some vertices.
  static std::vector<std::uint32_t> fans_of(std::span<const Numbered> vertices) {
    std::vector<std::uint32_t> fans;
    for (const Numbered& v : vertices)
      for (std::uint32_t i = 0; i < kFans[v.mask].count; ++i) fans.push_back(v.fan + i);
    return fans;
  }

  /// The numbers of all points of a part.
  std::vector<std::uint32_t> numbers_of(std::span<const Numbered> vertices, const Points& points,
                                        std::vector<std::uint32_t> fans) const {
    if (contacts_ == NonManifold::keep) {
      std::vector<std::uint32_t> numbers(vertices.size());
      std::ranges::transform(vertices, numbers.begin(), &Numbered::number);
      return numbers;
    }
    for (const Points::Midpoint& m : points.midpoints()) {
      const auto place =
          std::ranges::lower_bound(midpoint_keys_, Points::key(vertices[m.lower].number, m.axis));
      fans.push_back(static_cast<std::uint32_t>(result_.vertices.fans) +
                     static_cast<std::uint32_t>(place - midpoint_keys_.begin()));
    }
    return fans;
  }

  /// Counts shells. The lowest fan of a shell represents it, and the vertex of that fan tells whether the
  /// shell is a cavity: see find_shells.
  void count_shells() {
    ShellCounts& found = result_.counts.shells.emplace();
    each_block(2, [&](std::span<const Numbered> block) {
      for (const Numbered& v : block)
        for (std::uint32_t i = 0; i < kFans[v.mask].count; ++i) {
          if (shells_->find(v.fan + i) != v.fan + i) continue;
          ++found.shells;
          found.cavities += !(v.mask >> 7 & 1u);
        }
    });
  }

  ExternalUnion& solid_;
  NonManifold contacts_;
  Report& report_;
  ExternalBoundary result_;
  std::unique_ptr<Sorted> by_z_;
  std::array<std::unique_ptr<Runs>, 2> by_plane_;
  std::unique_ptr<SortedRuns<Midpoint>> midpoints_;  // if contacts are split
  std::vector<std::uint64_t> midpoint_keys_;         // of the midpoints, sorted
  std::unique_ptr<MeshWriter> writer_;
  std::optional<DisjointSets> shells_;
};

}  // namespace

ExternalBoundary write_boundary(ExternalUnion& solid, NonManifold contacts, bool triangles_only,
                                OutputFile file, Report& report) {
  ExternalBoundary result;
  solid.with_coordinates([&]<class C>(C) {
    result = BoundaryRun<C>(solid, contacts, report).run(triangles_only, std::move(file));
  });
  return result;
}

}  // namespace boxunion

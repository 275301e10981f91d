#include "core/brep.hpp"

#include <algorithm>
#include <limits>

#include "core/error.hpp"
#include "core/memory.hpp"
#include "core/plane_sweep.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kEdgeChunks = 64;
constexpr std::uint32_t kNone = Points::kNone;

/// A corner of a face: where its loop passes a vertex.
struct Corner {
  std::uint32_t vertex;        // position in the plane
  Quadrant quadrant;           // one that the face fills there
  std::uint32_t beside;        // a corner of the same face on a lower loop, if this may be a hole's first
  std::uint32_t next = kNone;  // corner on the loop, counter-clockwise seen from the axis' positive side
  std::uint32_t loop = kNone;
};

/// Links the corners of all faces of one plane and direction: the ends of an interval are edges, and remember
/// the corner whence they come. Corners come in order of row and column, so a loop's first is its lowest.
class CornerLinks {
 public:
  struct Interval {
    std::uint32_t left, right;
  };

  std::vector<Corner> corners;

  Interval start(std::size_t i) {
    const std::uint32_t c = add(i, right_above);
    return {c, c};
  }
  void end(const Interval& a, std::size_t i) {
    const std::uint32_t c = add(i, left_below);
    link(a.right, c);
    link(c, a.left);
  }
  void left(Interval& a, std::size_t i) {
    const std::uint32_t c = add(i, right_below);
    link(c, a.left);
    a.left = c;
  }
  void right(Interval& a, std::size_t i) {
    const std::uint32_t c = add(i, left_above);
    link(a.right, c);
    a.right = c;
  }
  Interval split(Interval& a, std::size_t i) {
    const std::uint32_t c = add(i, left_above, a.left);
    const Interval right_part = {c, a.right};
    a.right = c;
    return right_part;
  }
  void merge(Interval& a, const Interval& b, std::size_t i) {
    const std::uint32_t c = add(i, left_above);
    link(a.right, c);
    link(c, b.left);
    a.right = b.right;
  }

 private:
  std::uint32_t add(std::size_t vertex, Quadrant quadrant, std::uint32_t beside = kNone) {
    corners.push_back({static_cast<std::uint32_t>(vertex), quadrant, beside});
    return static_cast<std::uint32_t>(corners.size() - 1);
  }
  void link(std::uint32_t from, std::uint32_t to) { corners[from].next = to; }
};

/// The faces of some planes, with offsets from the first of them.
struct FacePart {
  std::vector<std::uint32_t> loop_points, loop_ends, face_ends;
  std::vector<std::uint8_t> direction;
};

/// Finds the faces of one plane at a time.
class PlaneFaces {
 public:
  explicit PlaneFaces(const Points& points) : points_(&points) {}

  void add(int axis, std::span<const PlaneVertex> plane, FacePart& part) {
    axis_ = axis;
    plane_ = plane;
    sweep_.assign(axis, plane);
    for (unsigned side = 0; side < 2; ++side) {
      links_.corners.clear();
      sweep_.run(side, links_);
      find_loops();
      for (std::size_t i = 0; i < loops_.size(); ++i) {
        write_loop(loops_[i].first, side, part);
        if (i + 1 < loops_.size() && loops_[i + 1].face == loops_[i].face) continue;
        part.face_ends.push_back(static_cast<std::uint32_t>(part.loop_ends.size()));
        part.direction.push_back(static_cast<std::uint8_t>(2 * axis + int(side)));
      }
    }
  }

 private:
  struct Loop {
    std::uint32_t first;  // corner
    std::uint32_t face;
  };

  /// Finds the loops and sorts them by face. A loop's lowest corner tells what it is: of an outer loop it is
  /// the start of an interval, of a hole it splits one, whose left end then lies on a loop of the same face
  /// that begins lower still.
  void find_loops() {
    std::vector<Corner>& corners = links_.corners;
    loops_.clear();
    std::uint32_t faces = 0;
    for (std::uint32_t first = 0; first < corners.size(); ++first) {
      if (corners[first].loop != kNone) continue;
      for (std::uint32_t c = first; corners[c].loop == kNone; c = corners[c].next)
        corners[c].loop = static_cast<std::uint32_t>(loops_.size());
      const std::uint32_t beside = corners[first].beside;
      loops_.push_back({first, beside == kNone ? faces++ : loops_[corners[beside].loop].face});
    }
    if (faces < loops_.size())
      std::stable_sort(loops_.begin(), loops_.end(),
                       [](const Loop& a, const Loop& b) { return a.face < b.face; });
  }

  void write_loop(std::uint32_t first, unsigned side, FacePart& part) {
    const std::size_t begin = part.loop_points.size();
    std::uint32_t c = first;
    do {
      const Corner& corner = links_.corners[c];
      const unsigned octant = octant_at(axis_, side, corner.quadrant);
      part.loop_points.push_back(points_->at(plane_[corner.vertex], octant, axis_));
      if (points_->contacts() == NonManifold::split) {
        const std::uint32_t midpoint = midpoint_after(corner, side);
        if (midpoint != kNone) part.loop_points.push_back(midpoint);
      }
      c = corner.next;
    } while (c != first);
    if (side == 1) std::reverse(part.loop_points.begin() + std::ptrdiff_t(begin) + 1, part.loop_points.end());
    part.loop_ends.push_back(static_cast<std::uint32_t>(part.loop_points.size()));
  }

  /// The midpoint of the edge from a corner to the next one, or kNone.
  std::uint32_t midpoint_after(const Corner& corner, unsigned side) const {
    const PlaneVertex &from = plane_[corner.vertex], &to = plane_[links_.corners[corner.next].vertex];
    const bool along_row = from.row == to.row;
    const int edge_axis = (axis_ + (along_row ? 1 : 2)) % 3;
    const bool ascends = along_row ? from.column < to.column : from.row < to.row;
    const Quadrant inside =
        along_row ? (ascends ? right_above : left_below) : (ascends ? left_above : right_below);
    const unsigned sector = octant_at(axis_, side, inside) >> (edge_axis + 1) % 3 & 1u;
    return points_->between((ascends ? from : to).vertex, edge_axis, int(sector));
  }

  const Points* points_;
  int axis_ = 0;
  std::span<const PlaneVertex> plane_;
  PlaneSweep<CornerLinks::Interval> sweep_;
  CornerLinks links_;
  std::vector<Loop> loops_;
};

/// Appends offsets of a part, moved by what came before it.
void append_moved(std::span<std::uint32_t> to, std::span<const std::uint32_t> ends, std::size_t before) {
  for (std::size_t i = 0; i < ends.size(); ++i) to[i] = static_cast<std::uint32_t>(before + ends[i]);
}

Faces joined(const std::vector<FacePart>& parts) {
  struct Sizes {
    std::size_t points = 0, loops = 0, faces = 0;
  };
  std::vector<Sizes> before(parts.size() + 1);
  for (std::size_t p = 0; p < parts.size(); ++p)
    before[p + 1] = {before[p].points + parts[p].loop_points.size(),
                     before[p].loops + parts[p].loop_ends.size(),
                     before[p].faces + parts[p].face_ends.size()};
  const Sizes& all = before.back();
  if (all.points > kNone)
    throw Error(ErrorKind::resources, "the loops of the boundary have more than 2^32 - 1 points");
  Faces faces;
  with_memory("the faces of the boundary", all.points * sizeof(std::uint32_t), [&] {
    faces.loop_points.resize(all.points);
    faces.first_point.resize(all.loops + 1);
    faces.first_loop.resize(all.faces + 1);
    faces.direction.resize(all.faces);
  });
  faces.first_point[0] = faces.first_loop[0] = 0;
  parallel_ranges(0, parts.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const FacePart& part = parts[p];
      std::copy(part.loop_points.begin(), part.loop_points.end(),
                faces.loop_points.begin() + std::ptrdiff_t(before[p].points));
      std::copy(part.direction.begin(), part.direction.end(),
                faces.direction.begin() + std::ptrdiff_t(before[p].faces));
      append_moved(std::span(faces.first_point).subspan(before[p].loops + 1), part.loop_ends,
                   before[p].points);
      append_moved(std::span(faces.first_loop).subspan(before[p].faces + 1), part.face_ends, before[p].loops);
    }
  });
  return faces;
}

}  // namespace

Faces find_faces(const Planes& planes, const Points& points) {
  const std::vector<PlaneChunk> chunks = cut_into_chunks(planes);
  std::vector<FacePart> parts(chunks.size());
  PerThread<PlaneFaces> finders{PlaneFaces(points)};
  parallel_ranges(0, chunks.size(), 1, [&](std::size_t first, std::size_t last) {
    PlaneFaces& finder = finders.local();
    for (std::size_t i = first; i < last; ++i) {
      const PlaneOrder& order = planes[chunks[i].axis];
      // Most vertices are a corner of one face an axis.
      parts[i].loop_points.reserve(order.vertices_of(chunks[i]).size() * 5 / 4);
      for (std::size_t p = chunks[i].begin; p < chunks[i].end; ++p)
        finder.add(chunks[i].axis, order.plane(p), parts[i]);
    }
  });
  return joined(parts);
}

Array<Edge> find_edges(const Planes& planes, const Points& points) {
  std::array<std::vector<Edge>, 3 * kEdgeChunks> parts;
  const bool split = points.contacts() == NonManifold::split;
  for_each_edge(planes, kEdgeChunks,
                [&](std::size_t chunk, int axis, const PlaneVertex& lower, const PlaneVertex& upper) {
                  std::vector<Edge>& part = parts[std::size_t(axis) * kEdgeChunks + chunk];
                  const int copies = split ? kOctants[lower.mask].edges[2 * axis] : 1;
                  for (int sector = 0; sector < copies; ++sector) {
                    const std::uint32_t from = points.at_edge(lower, 2 * axis, sector);
                    const std::uint32_t to = points.at_edge(upper, 2 * axis + 1, sector);
                    const std::uint32_t midpoint = points.between(lower.vertex, axis, sector);
                    if (midpoint == kNone) {
                      part.push_back({from, to});
                    } else {
                      part.push_back({from, midpoint});
                      part.push_back({midpoint, to});
                    }
                  }
                });
  std::array<std::size_t, 3 * kEdgeChunks + 1> before{};
  for (std::size_t p = 0; p < parts.size(); ++p) before[p + 1] = before[p] + parts[p].size();
  Array<Edge> edges;
  with_memory("the edges of the boundary", before.back() * sizeof(Edge),
              [&] { edges.resize(before.back()); });
  parallel_ranges(0, parts.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p)
      std::copy(parts[p].begin(), parts[p].end(), edges.begin() + std::ptrdiff_t(before[p]));
  });
  return edges;
}

Brep make_brep(const Solid& solid, NonManifold contacts,
               const std::function<void(std::string_view)>& finish) {
  const auto finished = [&](std::string_view stage) {
    if (finish) finish(stage);
  };
  const Planes planes = make_planes(solid);
  finished("planes");
  const Points points(solid, planes, contacts);
  Brep brep;
  brep.contacts = contacts;
  brep.points = points.positions();
  finished("points");
  brep.edges = find_edges(planes, points);
  finished("edges");
  brep.faces = find_faces(planes, points);
  finished("faces");
  brep.shells = find_shells(solid, planes, brep.faces, contacts);
  finished("shells");
  return brep;
}

}  // namespace boxunion

#include "core/boundary/faces.hpp"

#include <algorithm>
#include <limits>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/boundary/plane_sweep.hpp"

namespace boxunion {
namespace {

constexpr std::uint32_t kNone = Points::kNone;

/// A corner of a face, at a vertex of its loop.
struct Corner {
  std::uint32_t vertex;    // position in the plane
  Quadrant quadrant;       // a quadrant that the face fills there
  std::uint32_t beside;    // a corner of the same face on a lower loop, if this may be a hole's first corner
  std::uint32_t loop;      // kNone until it is found
  std::uint32_t next = 0;  // next corner on the loop, counter-clockwise seen from the positive side
};

/// Links the corners of all faces of one plane and direction. The ends of an interval are edges; each
/// remembers the corner where it came from. Corners come in order of row and column, so the first corner of a
/// loop is its lowest.
class CornerLinks {
 public:
  struct Interval {
    std::uint32_t left, right;
  };

  /// Prepares for a sweep of so many vertices.
  void reset(std::size_t vertices) {
    if (corners_.size() < 2 * vertices) corners_.resize(2 * vertices);
    count_ = 0;
  }
  std::span<Corner> corners() { return std::span(corners_).first(count_); }
  const Corner& corner(std::uint32_t c) const { return corners_[c]; }

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
    corners_[count_] = {static_cast<std::uint32_t>(vertex), quadrant, beside, kNone};
    return count_++;
  }
  void link(std::uint32_t from, std::uint32_t to) { corners_[from].next = to; }

  Array<Corner> corners_;  // at most two per vertex
  std::uint32_t count_ = 0;
};

/// The faces of some planes. Offsets count from the first of these faces.
struct FacePart {
  Array<std::uint32_t> loop_points;
  std::vector<std::uint32_t> loop_ends, face_ends;
  std::vector<std::uint8_t> direction;

  /// Reserves memory for planes with so many vertices. Most vertices are a corner of one face per axis.
  void reserve(std::size_t vertices) {
    loop_points.reserve(vertices * 5 / 4);
    for (auto* ends : {&loop_ends, &face_ends}) ends->reserve(vertices / 4);
    direction.reserve(vertices / 4);
  }
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
      if (sweep_.is_rectangle(side) && points_->contacts() == NonManifold::keep) {
        write_rectangle(side, part.loop_points);
      } else {
        links_.reset(plane.size());
        sweep_.run(side, links_);
        const std::uint32_t faces = write_loops(side, part.loop_points);
        if (faces < loops_.size()) sort_loops(part.loop_points);
      }
      for (std::size_t i = 0; i < loops_.size(); ++i) {
        part.loop_ends.push_back(loops_[i].end);
        if (i + 1 < loops_.size() && loops_[i + 1].face == loops_[i].face) continue;
        part.face_ends.push_back(static_cast<std::uint32_t>(part.loop_ends.size()));
        part.direction.push_back(static_cast<std::uint8_t>(2 * axis + int(side)));
      }
    }
  }

 private:
  struct Loop {
    std::uint32_t face;
    std::uint32_t begin, end;  // in loop_points
  };

  /// Writes the only loop of a side whose face is a rectangle.
  void write_rectangle(unsigned side, Array<std::uint32_t>& points) {
    constexpr std::array<std::array<std::uint32_t, 4>, 2> order = {{{0, 1, 3, 2}, {0, 2, 3, 1}}};
    const auto begin = static_cast<std::uint32_t>(points.size());
    for (const std::uint32_t i : order[side]) points.push_back(plane_[sweep_.vertices(side)[i].id].vertex);
    loops_.assign(1, {0, begin, begin + 4});
  }

  /// Finds the loops, writes their points, and returns the number of faces. The lowest corner of a loop tells
  /// what it is. That of an outer loop starts an interval. That of a hole splits an interval, whose left end
  /// then lies on a loop of the same face that begins lower still.
  std::uint32_t write_loops(unsigned side, Array<std::uint32_t>& points) {
    const std::span<Corner> corners = links_.corners();
    const bool keep = points_->contacts() == NonManifold::keep;
    loops_.clear();
    std::uint32_t faces = 0;
    auto end = static_cast<std::uint32_t>(points.size());
    points.resize(end + (keep ? 1 : 2) * corners.size());
    for (std::uint32_t first = 0; first < corners.size(); ++first) {
      if (corners[first].loop != kNone) continue;
      const std::uint32_t begin = end;
      const auto loop = static_cast<std::uint32_t>(loops_.size());
      std::uint32_t c = first;
      do {
        Corner& corner = corners[c];
        corner.loop = loop;
        if (keep) {
          points[end++] = plane_[corner.vertex].vertex;
        } else {
          points[end++] = points_->at(plane_[corner.vertex], octant_at(axis_, side, corner.quadrant), axis_);
          const std::uint32_t midpoint = midpoint_after(corner, side);
          if (midpoint != kNone) points[end++] = midpoint;
        }
        c = corner.next;
      } while (c != first);
      if (side == 1) std::reverse(points.begin() + begin + 1, points.begin() + end);
      const std::uint32_t beside = corners[first].beside;
      loops_.push_back({beside == kNone ? faces++ : loops_[corners[beside].loop].face, begin, end});
    }
    points.resize(end);
    return faces;
  }

  /// Sorts the loops by face.
  void sort_loops(Array<std::uint32_t>& points) {
    std::uint32_t end = loops_[0].begin;
    unsorted_.assign(points.begin() + end, points.end());
    std::stable_sort(loops_.begin(), loops_.end(),
                     [](const Loop& a, const Loop& b) { return a.face < b.face; });
    const std::uint32_t first = end;
    for (Loop& loop : loops_) {
      const auto source = unsorted_.begin() - first;
      std::copy(source + loop.begin, source + loop.end, points.begin() + end);
      end += loop.end - loop.begin;
      loop.end = end;
    }
  }

  /// The midpoint of the edge from a corner to the next one, or kNone.
  std::uint32_t midpoint_after(const Corner& corner, unsigned side) const {
    if (!points_->has_midpoints()) return kNone;
    const PlaneVertex &from = plane_[corner.vertex], &to = plane_[links_.corner(corner.next).vertex];
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
  std::vector<std::uint32_t> unsorted_;
};

/// Appends the offsets of a part, shifted by the size of the parts before it.
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
  parallel_for_each(0, parts.size(), 1, [&](std::size_t p) {
    const FacePart& part = parts[p];
    std::copy(part.loop_points.begin(), part.loop_points.end(),
              faces.loop_points.begin() + std::ptrdiff_t(before[p].points));
    std::copy(part.direction.begin(), part.direction.end(),
              faces.direction.begin() + std::ptrdiff_t(before[p].faces));
    append_moved(std::span(faces.first_point).subspan(before[p].loops + 1), part.loop_ends, before[p].points);
    append_moved(std::span(faces.first_loop).subspan(before[p].faces + 1), part.face_ends, before[p].loops);
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
      parts[i].reserve(order.vertices_of(chunks[i]).size());
      for (std::size_t p = chunks[i].begin; p < chunks[i].end; ++p)
        finder.add(chunks[i].axis, order.plane(p), parts[i]);
    }
  });
  return joined(parts);
}

Array<Edge> find_edges(const Planes& planes, const Points& points) {
  const bool split = points.contacts() == NonManifold::split;
  std::vector<std::vector<Edge>> parts(edge_parts(planes));
  for_each_edge(planes,
                [&](std::size_t number, int axis, const PlaneVertex& lower, const PlaneVertex& upper) {
                  std::vector<Edge>& part = parts[number];
                  if (!split) {
                    part.push_back({lower.vertex, upper.vertex});
                    return;
                  }
                  const int copies = kOctants[lower.mask].edges[2 * axis];
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
  std::vector<std::size_t> before(parts.size() + 1);
  for (std::size_t p = 0; p < parts.size(); ++p) before[p + 1] = before[p] + parts[p].size();
  Array<Edge> edges;
  with_memory("the edges of the boundary", before.back() * sizeof(Edge),
              [&] { edges.resize(before.back()); });
  parallel_for_each(0, parts.size(), 1, [&](std::size_t p) {
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

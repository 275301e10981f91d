#include "core/adjacency.hpp"

#include <algorithm>
#include <vector>

#include "core/face_join.hpp"
#include "core/parallel.hpp"
#include "core/radix_sort.hpp"

namespace boxunion {
namespace {

/// A box's face at one end of an axis: the rectangle [p_lo, p_hi] x [q_lo, q_hi].
struct Face {
  std::uint32_t plane, p_lo, p_hi, q_lo, q_hi;
  std::uint32_t box;
};

/// A box and one that begins where it ends.
struct Pair {
  std::uint32_t below, above;
};

/// The faces of all boxes at their low or high ends on an axis (0 A, 1 B), sorted by plane, p, q. p is the
/// other one of A and B, q is C.
Array<Face> find_faces(const std::vector<OrdinalBox>& boxes, std::size_t axis, bool high) {
  Array<Face> faces;
  with_memory("the faces of all boxes", boxes.size() * sizeof(Face), [&] { faces.resize(boxes.size()); });
  const std::size_t p = 1 - axis;
  parallel_ranges(0, boxes.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [lo, hi] = boxes[i];
      faces[i] = {high ? hi[axis] : lo[axis], lo[p], hi[p], lo[2], hi[2], std::uint32_t(i)};
    }
  });
  if (axis != 0 || high)  // as the boxes are sorted
    radix_sort(std::span(faces), [](const Face& f) {
      return static_cast<unsigned __int128>(f.plane) << 64 | (std::uint64_t(f.p_lo) << 32 | f.q_lo);
    });
  return faces;
}

/// The faces of two sets that lie in one plane.
struct PlaneFaces {
  std::span<const Face> below, above;
};

std::vector<PlaneFaces> match_planes(std::span<const Face> below, std::span<const Face> above) {
  const auto take_plane = [](std::span<const Face>& faces) {
    std::size_t count = 1;
    while (count < faces.size() && faces[count].plane == faces[0].plane) ++count;
    const std::span<const Face> taken = faces.first(count);
    faces = faces.subspan(count);
    return taken;
  };
  std::vector<PlaneFaces> planes;
  while (!below.empty() && !above.empty()) {
    if (below[0].plane < above[0].plane)
      take_plane(below);
    else if (above[0].plane < below[0].plane)
      take_plane(above);
    else
      planes.push_back({take_plane(below), take_plane(above)});
  }
  return planes;
}

/// Takes the faces from the front that begin at p.
std::span<const Face> take_begun(std::span<const Face>& faces, std::uint32_t p) {
  std::size_t count = 0;
  while (count < faces.size() && faces[count].p_lo == p) ++count;
  const std::span<const Face> taken = faces.first(count);
  faces = faces.subspan(count);
  return taken;
}

/// Finds the pairs of a plane. Both of its sets are sorted by p, then q.
void join_plane(PlaneFaces faces, FaceJoin<Face>& join, std::vector<Pair>& pairs) {
  auto& [below, above] = faces;
  join.clear();
  while (!below.empty() || !above.empty()) {
    const std::uint32_t p = std::min(below.empty() ? above[0].p_lo : below[0].p_lo,
                                     above.empty() ? below[0].p_lo : above[0].p_lo);
    const std::span<const Face> new_below = take_begun(below, p), new_above = take_begun(above, p);
    join.advance(new_below, new_above, [&](const Face& f, const Face& g) {
      pairs.push_back({f.box, g.box});
    });
  }
}

/// The lists of entries that for_each_entry(add) gives to add(box, neighbor), in its order; it is called
/// twice.
template <class F>
NeighborLists make_lists(std::size_t boxes, std::size_t entries, F&& for_each_entry) {
  NeighborLists lists;
  with_memory("the neighbours of all boxes", 4 * entries + 8 * boxes, [&] {
    lists.boxes.resize(entries);
    lists.offsets.assign(boxes + 2, 0);
  });
  std::uint64_t* const next = lists.offsets.data() + 1;  // first of box i, at last of box i + 1
  for_each_entry([&](std::uint32_t box, std::uint32_t) { ++next[box + 1]; });
  for (std::size_t i = 0; i < boxes; ++i) next[i + 1] += next[i];
  for_each_entry([&](std::uint32_t box, std::uint32_t neighbor) { lists.boxes[next[box]++] = neighbor; });
  lists.offsets.pop_back();
  return lists;
}

/// The same pairs from the other side, ascending.
NeighborLists transposed(const NeighborLists& lists) {
  const std::size_t boxes = lists.offsets.size() - 1;
  return make_lists(boxes, lists.boxes.size(), [&](auto&& add) {
    for (std::size_t i = 0; i < boxes; ++i)
      for (const std::uint32_t neighbor : lists[i]) add(neighbor, std::uint32_t(i));
  });
}

}  // namespace

Adjacency find_neighbors(const Decomposition& decomposition, Connectivity connectivity) {
  validate(connectivity);
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  const bool touch = connectivity == Connectivity::points;
  Adjacency adjacency;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Array<Face> high = find_faces(boxes, axis, true), low = find_faces(boxes, axis, false);
    const std::vector<PlaneFaces> planes = match_planes(high, low);
    PerThread<FaceJoin<Face>> joins([&] { return FaceJoin<Face>(touch && axis == 0, touch); });
    PerThread<std::vector<Pair>> pairs;
    parallel_ranges(0, planes.size(), 1, [&](std::size_t begin, std::size_t end) {
      FaceJoin<Face>& join = joins.local();
      std::vector<Pair>& found = pairs.local();
      for (std::size_t i = begin; i < end; ++i) join_plane(planes[i], join, found);
    });
    std::size_t count = 0;
    pairs.for_each([&](const std::vector<Pair>& part) { count += part.size(); });
    const NeighborLists forward = make_lists(boxes.size(), count, [&](auto&& add) {
      pairs.for_each([&](const std::vector<Pair>& part) {
        for (const Pair& pair : part) add(pair.below, pair.above);
      });
    });
    adjacency.backward[axis] = transposed(forward);
    adjacency.forward[axis] = transposed(adjacency.backward[axis]);  // ascending now
  }
  return adjacency;
}

}  // namespace boxunion

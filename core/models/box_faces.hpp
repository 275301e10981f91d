#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/decomposition.hpp"
#include "boxunion/volume.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/radix_sort.hpp"
#include "core/models/face_join.hpp"

namespace boxunion {
namespace detail {

/// The face of a box at one end of an axis: the rectangle [p_lo, p_hi] x [q_lo, q_hi].
struct Face {
  std::uint32_t plane, p_lo, p_hi, q_lo, q_hi;
  std::uint32_t box;
};

/// The faces of all boxes at their low or high ends on an axis (0 A, 1 B), sorted by plane, p and q. p runs
/// along the other one of A and B, q along C.
inline Array<Face> find_faces(const std::vector<OrdinalBox>& boxes, std::size_t axis, bool high) {
  Array<Face> faces;
  with_memory("the faces of all boxes", boxes.size() * sizeof(Face), [&] { faces.resize(boxes.size()); });
  const std::size_t p = 1 - axis;
  parallel_for_each(0, boxes.size(), 1 << 14, [&](std::size_t i) {
    const auto& [lo, hi] = boxes[i];
    faces[i] = {high ? hi[axis] : lo[axis], lo[p], hi[p], lo[2], hi[2], std::uint32_t(i)};
  });
  if (axis != 0 || high)  // otherwise the boxes are sorted like this
    radix_sort(std::span(faces), [](const Face& f) {
      return static_cast<unsigned __int128>(f.plane) << 64 | (std::uint64_t(f.p_lo) << 32 | f.q_lo);
    });
  return faces;
}

/// The faces of two sets in one plane.
struct PlaneFaces {
  std::span<const Face> below, above;
};

inline std::vector<PlaneFaces> match_planes(std::span<const Face> below, std::span<const Face> above) {
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

/// Takes the faces that begin at p from the front.
inline std::span<const Face> take_begun(std::span<const Face>& faces, std::uint32_t p) {
  std::size_t count = 0;
  while (count < faces.size() && faces[count].p_lo == p) ++count;
  const std::span<const Face> taken = faces.first(count);
  faces = faces.subspan(count);
  return taken;
}

/// Joins the faces of a plane. Both sets are sorted by p, then q.
template <FacePairs kPairs, class Add>
void join_plane(PlaneFaces faces, FaceJoin<Face, kPairs>& join, Add&& add) {
  auto& [below, above] = faces;
  join.clear();
  while (!below.empty() || !above.empty()) {
    const std::uint32_t p = std::min(below.empty() ? above[0].p_lo : below[0].p_lo,
                                     above.empty() ? below[0].p_lo : above[0].p_lo);
    const std::span<const Face> new_below = take_begun(below, p), new_above = take_begun(above, p);
    join.advance(new_below, new_above, [&](const Face& f, const Face& g) { add(f.box, g.box); });
  }
}

}  // namespace detail

/// Joins the boxes of a decomposition across their ends on an axis (0 A, 1 B): see Adjacency and FacePairs.
/// Each part of the work calls make_add() on its thread, and then calls the result as add(box, neighbor),
/// where the neighbor begins where the box ends.
template <FacePairs kPairs, class MakeAdd>
void join_boxes(const Decomposition& decomposition, Connectivity connectivity, std::size_t axis,
                MakeAdd&& make_add) {
  using Join = FaceJoin<detail::Face, kPairs>;
  const bool touch = connectivity == Connectivity::points;
  const Array<detail::Face> high = detail::find_faces(decomposition.boxes, axis, true),
                            low = detail::find_faces(decomposition.boxes, axis, false);
  const std::vector<detail::PlaneFaces> planes = detail::match_planes(high, low);
  PerThread<Join> joins([&] { return Join(touch && axis == 0, touch); });
  parallel_ranges(0, planes.size(), 1, [&](std::size_t begin, std::size_t end) {
    Join& join = joins.local();
    auto add = make_add();
    for (std::size_t i = begin; i < end; ++i) detail::join_plane(planes[i], join, add);
  });
}

}  // namespace boxunion

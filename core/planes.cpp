#include "core/planes.hpp"

#include <algorithm>
#include <limits>

#include "core/error.hpp"
#include "core/memory.hpp"
#include "core/radix_sort.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kGrain = 1 << 15;  // vertices

/// An ordinal above the index of a vertex.
using Keyed = std::uint64_t;

/// A function object, so that sorting inlines it.
constexpr auto ordinal_of = [](Keyed k) { return static_cast<std::uint32_t>(k >> 32); };

PlaneOrder plane_order(std::span<const Keyed> sorted) {
  PlaneOrder order;
  with_memory("sorting the vertices into planes", sorted.size() * sizeof(std::uint32_t),
              [&] { order.vertices.resize(sorted.size()); });
  parallel_ranges(0, sorted.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) order.vertices[i] = static_cast<std::uint32_t>(sorted[i]);
  });
  for (std::size_t i = 0; i < sorted.size(); ++i)
    if (i == 0 || ordinal_of(sorted[i]) != ordinal_of(sorted[i - 1]))
      order.first.push_back(static_cast<std::uint32_t>(i));
  order.first.push_back(static_cast<std::uint32_t>(sorted.size()));
  return order;
}

}  // namespace

Planes make_planes(const Solid& solid) {
  const std::size_t count = solid.vertices.size();
  if (count > std::numeric_limits<std::uint32_t>::max() - 1)
    throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 2 vertices");
  Array<Keyed> keyed = with_memory("sorting the vertices into planes", count * sizeof(Keyed),
                                   [&] { return Array<Keyed>(count); });
  Array<Keyed> scratch = with_memory("sorting the vertices into planes", count * sizeof(Keyed),
                                     [&] { return Array<Keyed>(count); });
  const auto key_by = [&](int axis) {
    parallel_ranges(0, count, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto vertex = static_cast<std::uint32_t>(axis == 2 ? i : keyed[i]);
        keyed[i] = Keyed{ordinal(solid.vertices[vertex], axis)} << 32 | vertex;
      }
    });
  };
  // Sorted by z, y, x as the vertices are; stably by x makes that x, z, y, and stably by y then makes it y,
  // x, z.
  Planes planes;
  for (const int axis : {2, 0, 1}) {
    key_by(axis);
    if (axis != 2) radix_sort(std::span(keyed), std::span(scratch), ordinal_of);
    planes[axis] = plane_order(keyed);
  }
  return planes;
}

void PlaneVertices::assign(const Solid& solid, int axis, std::span<const std::uint32_t> plane) {
  axis_ = axis;
  columns_.resize(plane.size());
  masks_.resize(plane.size());
  std::uint32_t lowest = Axis::kOrdinalMax, highest = 0;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Vertex& v = solid.vertices[plane[i]];
    masks_[i] = static_cast<std::uint8_t>(v.mask);
    columns_[i] = ordinal(v, (axis + 1) % 3);
    lowest = std::min(lowest, columns_[i]);
    highest = std::max(highest, columns_[i]);
  }
  if (highest - lowest >= kFew) return rank_columns();
  for (std::uint32_t& column : columns_) column -= lowest;
  column_count_ = highest - lowest + 1;
}

void PlaneVertices::rank_columns() {
  sorted_.resize(columns_.size());
  scratch_.resize(columns_.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) sorted_[i] = Keyed{columns_[i]} << 32 | i;
  radix_sort(std::span(sorted_), std::span(scratch_), ordinal_of);
  std::uint32_t rank = 0;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    rank += i > 0 && ordinal_of(sorted_[i]) != ordinal_of(sorted_[i - 1]);
    columns_[static_cast<std::uint32_t>(sorted_[i])] = rank;
  }
  column_count_ = rank + 1;
}

}  // namespace boxunion

#include "core/boundary/points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/radix_sort.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kFanGrain = 1 << 12;  // vertices

[[noreturn]] void throw_too_many() {
  throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 2 points");
}

}  // namespace

Fans::Fans(const Solid& solid) {
  const std::size_t count = solid.vertices.size();
  with_memory("numbering the vertices' fans", count * sizeof(std::uint32_t), [&] { first_.resize(count); });
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    first_[i] = static_cast<std::uint32_t>(sum);
    sum += kFans[solid.vertices[i].mask].count;
  }
  if (sum >= Points::kNone) throw_too_many();
  count_ = static_cast<std::uint32_t>(sum);
}

Array<std::uint32_t> Fans::vertices() const {
  auto vertices = make_array<std::uint32_t>(count_, "numbering the vertices' fans");
  parallel_for_each(0, first_.size(), kFanGrain, [&](std::size_t i) {
    std::fill(vertices.begin() + first_[i],
              vertices.begin() + (i + 1 < first_.size() ? first_[i + 1] : count_), std::uint32_t(i));
  });
  return vertices;
}

Point midpoint(const Point& lower, const Point& upper, int axis) {
  Point middle = lower;
  middle[axis] = std::midpoint(lower[axis], upper[axis]);
  if (middle[axis] <= lower[axis] || upper[axis] <= middle[axis])
    throw Error(ErrorKind::input, fmt::format("cannot split an edge from {} to {}: no double lies between",
                                              lower[axis], upper[axis]));
  return middle;
}

Points::Points(const Solid& solid, const Planes& planes, NonManifold contacts)
    : solid_(&solid), contacts_(contacts), fans_(contacts == NonManifold::split ? Fans(solid) : Fans({})) {
  if (contacts == NonManifold::keep) return;
  std::vector<std::vector<Midpoint>> parts(edge_parts(planes));
  for_each_edge(planes, [&](std::size_t part, int axis, const PlaneVertex& lower, const PlaneVertex& upper) {
    if (needs_midpoint(lower.mask, upper.mask, axis))
      parts[part].push_back({lower.vertex, upper.vertex, axis});
  });
  for (const auto& part : parts) midpoints_.insert(midpoints_.end(), part.begin(), part.end());
  radix_sort(std::span(midpoints_), [](const Midpoint& m) { return key(m.lower, m.axis); });
  if (size() >= kNone) throw_too_many();
}

std::size_t Points::size() const {
  return contacts_ == NonManifold::keep ? solid_->vertices.size() : fans_.count() + midpoints_.size();
}

std::uint32_t Points::between(std::uint32_t lower, int axis, int sector) const {
  if (sector == 0 || midpoints_.empty()) return kNone;
  const auto place =
      std::lower_bound(midpoints_.begin(), midpoints_.end(), key(lower, axis),
                       [](const Midpoint& m, std::uint64_t wanted) { return key(m.lower, m.axis) < wanted; });
  if (place == midpoints_.end() || place->lower != lower || place->axis != axis) return kNone;
  return fans_.count() + static_cast<std::uint32_t>(place - midpoints_.begin());
}

Array<Point> Points::positions() const {
  auto positions = make_array<Point>(size(), "the points of the boundary");
  const Coordinates x(solid_->axes[0]), y(solid_->axes[1]), z(solid_->axes[2]);
  const auto position = [&](std::uint32_t vertex) {
    const Vertex& v = solid_->vertices[vertex];
    return Point{x(v.x), y(v.y), z(v.z)};
  };
  if (contacts_ == NonManifold::keep) {
    parallel_for_each(0, positions.size(), kFanGrain,
                      [&](std::size_t i) { positions[i] = position(std::uint32_t(i)); });
    return positions;
  }
  const Array<std::uint32_t> vertices = fans_.vertices();
  parallel_for_each(0, vertices.size(), kFanGrain,
                    [&](std::size_t i) { positions[i] = position(vertices[i]); });
  for (std::size_t i = 0; i < midpoints_.size(); ++i) {
    const Midpoint& m = midpoints_[i];
    positions[vertices.size() + i] = midpoint(position(m.lower), position(m.upper), m.axis);
  }
  return positions;
}

}  // namespace boxunion

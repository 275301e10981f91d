#include "core/boundary/planes.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "boxunion/error.hpp"
#include "core/base/counting_sort.hpp"
#include "core/base/memory.hpp"
#include "core/base/radix_sort.hpp"

namespace boxunion {
namespace {

constexpr auto kWhat = "sorting the vertices into planes";
constexpr std::size_t kVertexGrain = 1 << 14;                       // vertices
constexpr std::size_t kLeastChunk = 1 << 11, kMostChunk = 1 << 13;  // vertices
constexpr std::uint32_t kCounted = 1 << 16;  // so many counters fit the cache of a core

/// An ordinal in the high half, a position in the low half.
using Keyed = std::uint64_t;

/// A function object, so that sorting can inline it.
constexpr auto ordinal_of = [](Keyed k) { return static_cast<std::uint32_t>(k >> 32); };

/// The starts of the runs of equal ordinals among `count` ordinals. There are at most `most` runs.
template <class Ordinal>
std::vector<std::uint32_t> first_of_runs(std::size_t count, std::size_t most, Ordinal ordinal) {
  std::vector<std::uint32_t> first(std::min(count, most) + 1);
  std::size_t runs = 0;
  for (std::size_t i = 0; i < count; ++i) {
    first[runs] = static_cast<std::uint32_t>(i);
    runs += i == 0 || ordinal(i) != ordinal(i - 1);  // branch-free, because the branch would be unpredictable
  }
  first.resize(runs);
  return first;
}

/// Sorts vertices into planes, stably. Vertex i is vertex(i); its plane is that of ordinal(i), which is less
/// than `ordinals`.
template <class Ordinal, class VertexOf>
class PlaneSort {
 public:
  PlaneSort(std::size_t count, std::uint32_t ordinals, Ordinal ordinal, VertexOf vertex)
      : count_(count), ordinals_(ordinals), ordinal_(ordinal), vertex_(vertex) {}

  PlaneOrder operator()() {
    order_.vertices = make_array<PlaneVertex>(count_, kWhat);
    if (ordinals_ <= kCounted)
      by_counting();
    else
      by_sorting();
    order_.first.push_back(static_cast<std::uint32_t>(count_));
    return std::move(order_);
  }

 private:
  void by_counting() {
    if (count_ >= ordinals_) return by_counting(ordinals_, ordinal_);
    // if many ordinals have no vertex, count only those that have one
    std::vector<std::uint64_t> occurs(ordinals_ / 64 + 1);
    for (std::size_t i = 0; i < count_; ++i) occurs[ordinal_(i) / 64] |= std::uint64_t{1} << ordinal_(i) % 64;
    std::vector<std::uint32_t> rank(ordinals_);
    std::uint32_t ranks = 0;
    for (std::size_t w = 0; w < occurs.size(); ++w)
      for (std::uint64_t bits = occurs[w]; bits != 0; bits &= bits - 1)
        rank[64 * w + std::size_t(std::countr_zero(bits))] = ranks++;
    by_counting(ranks, [&](std::size_t i) { return rank[ordinal_(i)]; });
  }

  /// Sorts by counting. Vertex i goes to key(i), which is less than `keys`.
  template <class Key>
  void by_counting(std::uint32_t keys, Key key) {
    const std::size_t chunks = std::clamp(count_ / kVertexGrain, std::size_t(1), thread_count());
    const auto keys_of = [&](std::size_t i, auto&& f) { f(key(i)); };
    CountingSort<std::uint32_t, decltype(keys_of)> sorting(count_, keys, chunks, keys_of);
    sorting.scatter([&](std::size_t i, std::uint32_t place) { order_.vertices[place] = vertex_(i); });
    order_.first.resize(keys);
    std::uint32_t begin = 0;
    std::size_t planes = 0;
    for (const std::uint32_t end : sorting.ends()) {
      order_.first[planes] = begin;
      planes += end != std::exchange(begin, end);  // branch-free: which ordinals occur is unpredictable
    }
    order_.first.resize(planes);
  }

  void by_sorting() {
    auto sorted = make_array<Keyed>(count_, kWhat);
    parallel_for_each(0, count_, kVertexGrain,
                      [&](std::size_t i) { sorted[i] = Keyed{ordinal_(i)} << 32 | i; });
    radix_sort(std::span(sorted), ordinal_of);
    parallel_for_each(0, count_, kVertexGrain, [&](std::size_t i) {
      order_.vertices[i] = vertex_(static_cast<std::uint32_t>(sorted[i]));
    });
    order_.first = first_of_runs(count_, ordinals_, [&](std::size_t i) { return ordinal_of(sorted[i]); });
  }

  std::size_t count_;
  std::uint32_t ordinals_;
  Ordinal ordinal_;
  VertexOf vertex_;
  PlaneOrder order_;
};

}  // namespace

Planes make_planes(const Solid& solid) {
  const Array<Vertex>& all = solid.vertices;
  const std::size_t count = all.size();
  if (count > std::numeric_limits<std::uint32_t>::max() - 1)
    throw Error(ErrorKind::resources, "the boundary has more than 2^32 - 2 vertices");
  // The vertices are sorted by z, y, x. A stable sort by x gives x, z, y, and then a stable sort by y gives
  // y, x, z.
  const auto sorted = [&](int axis, auto ordinal, auto vertex) {
    return PlaneSort(count, solid.axes[unsigned(axis)].count() + 1, ordinal, vertex)();
  };
  Planes planes;
  planes[2].vertices = make_array<PlaneVertex>(count, kWhat);
  parallel_for_each(0, count, kVertexGrain, [&](std::size_t i) {
    planes[2].vertices[i] = {static_cast<std::uint32_t>(i), all[i].x, all[i].y, all[i].mask};
  });
  planes[2].first = first_of_runs(count, solid.axes[2].count() + 1, [&](std::size_t i) { return all[i].z; });
  planes[2].first.push_back(static_cast<std::uint32_t>(count));
  planes[0] = sorted(
      0, [&](std::size_t i) { return all[i].x; },
      [&](std::size_t i) {
        return PlaneVertex{static_cast<std::uint32_t>(i), all[i].y, all[i].z, all[i].mask};
      });
  const Array<PlaneVertex>& by_x = planes[0].vertices;
  // a copy in the order by x; to read them from `all` would be random access
  auto x = make_array<std::uint32_t>(count, kWhat);
  parallel_for_each(0, planes[0].planes(), kVertexGrain / 4, [&](std::size_t p) {
    const std::uint32_t first = planes[0].first[p];
    std::fill(x.begin() + first, x.begin() + planes[0].first[p + 1], all[by_x[first].vertex].x);
  });
  planes[1] = sorted(
      1, [&](std::size_t i) { return by_x[i].column; },
      [&](std::size_t i) {
        return PlaneVertex{by_x[i].vertex, by_x[i].row, x[i], by_x[i].mask};
      });
  return planes;
}

std::vector<PlaneChunk> cut_into_chunks(const Planes& planes) {
  std::vector<PlaneChunk> chunks;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::uint32_t>& first = planes[unsigned(axis)].first;
    const std::size_t chunk =
        std::clamp(planes[unsigned(axis)].vertices.size() / 64, kLeastChunk, kMostChunk);
    for (std::size_t begin = 0, end = 0; begin < planes[unsigned(axis)].planes(); begin = end) {
      while (end < planes[unsigned(axis)].planes() && first[end] < first[begin] + chunk) ++end;
      chunks.push_back({axis, begin, end});
    }
  }
  return chunks;
}

void PlaneColumns::assign(std::span<const PlaneVertex> plane) {
  plane_ = plane;
  ranks_.clear();
  std::uint32_t highest = 0;
  lowest_ = Axis::kOrdinalMax;
  for (const PlaneVertex& v : plane) {
    lowest_ = std::min(lowest_, v.column);
    highest = std::max(highest, v.column);
  }
  count_ = highest - lowest_ + 1;
  if (count_ <= kFew) return;

  ranks_.assign(plane.size(), [&](std::size_t i) { return plane[i].column; });
  count_ = ranks_.distinct();
}

}  // namespace boxunion

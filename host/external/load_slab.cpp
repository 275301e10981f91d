#include "host/external/load_slab.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <span>
#include <vector>

#include "core/base/memory.hpp"
#include "host/engine/cells_method.hpp"

namespace boxunion {
namespace {

using Ordinal = std::uint32_t;

/// All boxes of a source, each as convert(box), in memory.
template <class T, class C, class Convert>
std::vector<T> load(const BoxSource<C>& source, Convert&& convert) {
  std::vector<T> all = with_memory("the boxes of a slab", source.count() * sizeof(T),
                                   [&] { return std::vector<T>(source.count()); });
  std::atomic<std::size_t> next = 0;
  source.each_piece([&](std::span<const BoxOf<C>> boxes) {
    std::size_t place = next.fetch_add(boxes.size());
    for (const BoxOf<C>& box : boxes) all[place++] = convert(box);
  });
  return all;
}

/// The first ordinal of an axis whose coordinate is at least `coordinate`.
Ordinal first_ordinal(const Axis& axis, double coordinate) {
  Ordinal begin = 1, end = axis.count() + 1;
  while (begin < end) {
    const Ordinal middle = begin + (end - begin) / 2;
    if (axis.coordinate(middle) < coordinate)
      begin = middle + 1;
    else
      end = middle;
  }
  return begin;
}

}  // namespace

Ordinals load_slab(const BoxSource<Ordinal>& source, const RegionOf<Ordinal>& region, const Axes& axes) {
  std::array<Ordinal, 3> shift{};  // modulo 2^32
  Ordinals slab;
  OrdinalBox own;
  for (unsigned a = 0; a < 3; ++a) {
    const Ordinal lo = region.lo[a], hi = region.hi[a];
    const bool moves = lo > 0 && hi - lo < 1u << 31;
    const std::int64_t by = moves ? (std::int64_t{1} << kRegionLogEdge) - lo : 0;
    shift[a] = static_cast<Ordinal>(by);
    own.lo[a] = lo + shift[a];
    own.hi[a] = hi + shift[a];
    slab.axes[a] =
        Axis::lattice(axes[a].base() - by, axes[a].exponent(), std::min(hi, axes[a].count()) + shift[a]);
  }
  slab.boxes = load<OrdinalBox>(source, [&](const BoxOf<Ordinal>& b) {
    return OrdinalBox{{b[0] + shift[0], b[1] + shift[1], b[2] + shift[2]},
                      {b[3] + shift[0], b[4] + shift[1], b[5] + shift[2]}};
  });
  slab.ends = {slab.boxes.size()};
  slab.region = own;
  return slab;
}

Ordinals load_slab(const BoxSource<double>& source, const RegionOf<double>& region, const Axes&) {
  const BoxSet boxes(load<Box>(source, [](const Box& box) { return box; }));
  Ordinals slab = make_ordinals(boxes);
  if (std::ranges::all_of(slab.axes, &Axis::is_lattice)) {
    slab.axes = make_rank_axes(boxes);
    slab.boxes = ordinal_boxes(boxes, slab.axes);
  }
  slab.region.emplace();
  for (unsigned a = 0; a < 3; ++a) {
    slab.region->lo[a] = first_ordinal(slab.axes[a], region.lo[a]);
    slab.region->hi[a] = first_ordinal(slab.axes[a], region.hi[a]);
  }
  return slab;
}

}  // namespace boxunion

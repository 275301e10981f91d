#include "core/decomposition.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "core/error.hpp"
#include "core/memory.hpp"
#include "core/parallel.hpp"
#include "core/radix_sort.hpp"
#include "core/section_rectangles.hpp"

namespace boxunion {
namespace {

constexpr std::uint64_t kMostBoxes = 0xffffffffu;

/// Calls add(box) for every interval between neighbouring lines of vertices of every section.
template <class Add>
void find_oudb(const Evm& evm, Add&& add) {
  for (SectionSweep<3> planes{std::span(evm.vertices)}; planes.next() != Axis::kOrdinalMax;) {
    const std::uint32_t a = planes.next();
    planes.advance();
    for (SectionSweep<2> lines{std::span(planes.section())}; lines.next() != Axis::kOrdinalMax;) {
      const std::uint32_t b = lines.next();
      lines.advance();
      const ExtremeVertices<1>& ends = lines.section();
      for (std::size_t i = 0; i < ends.size(); i += 2)
        add(OrdinalBox{{a, b, ends[i][0]}, {planes.next(), lines.next(), ends[i + 1][0]}});
    }
  }
}

/// Calls f(a, rectangles) behind each plane of vertices.
template <class F>
void sweep_rectangles(const Evm& evm, F&& f) {
  SectionRectangles rectangles;
  ExtremeVertices<2> plane;
  std::uint64_t boxes = 0;
  for (auto v = evm.vertices.begin(); v != evm.vertices.end();) {
    const std::uint32_t a = (*v)[0];
    plane.clear();
    for (; v != evm.vertices.end() && (*v)[0] == a; ++v) plane.push_back({(*v)[1], (*v)[2]});
    rectangles.pass(plane, std::uint32_t(boxes));
    f(a, rectangles);
    boxes += rectangles.begun().size();
  }
}

unsigned __int128 corner_key(const OrderedPoint<3>& p) {
  return static_cast<unsigned __int128>(p[0]) << 64 | (std::uint64_t(p[1]) << 32 | p[2]);
}

/// Are all coordinates of an axis integers of 32 bits?
bool holds_int32(const Axis& axis) {
  if (!axis.is_lattice() || axis.exponent() < 0) return false;
  using Limits = std::numeric_limits<std::int32_t>;
  return axis.count() == 0 ||
         (axis.coordinate(1) >= Limits::min() && axis.coordinate(axis.count()) <= Limits::max());
}

}  // namespace

Decomposition decompose(const Evm& evm, BoxModel model) {
  Decomposition result{evm.axes, evm.order, {}};
  const auto add = [&](const OrdinalBox& box) {
    if (result.boxes.size() == kMostBoxes)
      throw Error(ErrorKind::resources, "the decomposition has 2^32 boxes or more");
    result.boxes.push_back(box);
  };
  with_memory("the decomposition", sizeof(OrdinalBox) * evm.vertices.size(), [&] {
    if (model == BoxModel::oudb) return find_oudb(evm, add);
    sweep_rectangles(evm, [&](std::uint32_t a, const SectionRectangles& rectangles) {
      for (const std::uint32_t box : rectangles.ended()) result.boxes[box].hi[0] = a;
      for (const SectionRectangle& r : rectangles.begun()) add({{a, r.b_lo, r.c_lo}, {0, r.b_hi, r.c_hi}});
    });
  });
  return result;
}

std::uint64_t count_boxes(const Evm& evm, BoxModel model) {
  std::uint64_t count = 0;
  if (model == BoxModel::oudb)
    find_oudb(evm, [&](const OrdinalBox&) { ++count; });
  else
    sweep_rectangles(
        evm, [&](std::uint32_t, const SectionRectangles& rectangles) { count += rectangles.begun().size(); });
  return count;
}

Evm make_evm(const Decomposition& decomposition) {
  Evm evm{decomposition.axes, decomposition.order, {}};
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  Array<OrderedPoint<3>> corners;
  with_memory("the corners of all boxes", 8 * boxes.size() * sizeof(OrderedPoint<3>),
              [&] { corners.resize(8 * boxes.size()); });
  parallel_ranges(0, boxes.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = 0; k < 8; ++k) {
        const auto& [lo, hi] = boxes[i];
        corners[8 * i + k] = {k & 4 ? hi[0] : lo[0], k & 2 ? hi[1] : lo[1], k & 1 ? hi[2] : lo[2]};
      }
  });
  radix_sort(std::span(corners), corner_key);
  for (std::size_t i = 0; i < corners.size();) {
    std::size_t j = i;
    while (j < corners.size() && corners[j] == corners[i]) ++j;
    if ((j - i) % 2 != 0) evm.vertices.push_back(corners[i]);
    i = j;
  }
  return evm;
}

BoxSet to_boxes(const Decomposition& decomposition) {
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  std::array<std::size_t, 3> place{};  // of x, y, z in the order
  for (std::size_t i = 0; i < 3; ++i) place[decomposition.order[i]] = i;
  const auto convert = [&]<class T>(std::vector<BoxOf<T>> result) {
    with_memory("the boxes", boxes.size() * sizeof(BoxOf<T>), [&] { result.resize(boxes.size()); });
    parallel_ranges(0, boxes.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
          result[i][axis] = T(decomposition.axes[axis].coordinate(boxes[i].lo[place[axis]]));
          result[i][axis + 3] = T(decomposition.axes[axis].coordinate(boxes[i].hi[place[axis]]));
        }
    });
    return BoxSet(std::move(result));
  };
  const bool integers = std::all_of(decomposition.axes.begin(), decomposition.axes.end(), holds_int32);
  return integers ? convert(std::vector<IntegerBox>()) : convert(std::vector<Box>());
}

}  // namespace boxunion

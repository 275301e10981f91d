#include "boxunion/decomposition.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/radix_sort.hpp"
#include "core/models/box_sweep.hpp"

namespace boxunion {
namespace {

constexpr std::uint64_t kMostBoxes = 0xffffffffu;

[[noreturn]] void throw_too_many() {
  throw Error(ErrorKind::resources, "the decomposition has 2^32 boxes or more");
}

/// Thrown if a sweep finds more boxes than allowed.
struct TooMany {};

/// Of sorted points, keeps one of each that occurs an odd number of times.
template <class Points>
void keep_odd(Points& points) {
  auto out = points.begin();
  for (auto i = points.begin(); i != points.end();) {
    const auto point = *i;
    bool odd = false;
    for (; i != points.end() && *i == point; ++i) odd = !odd;
    if (odd) *out++ = point;
  }
  points.erase(out, points.end());
}

/// Calls add(low corner, high corner) for every box of the OUDB, in order.
template <class Add>
void find_oudb(const Evm& evm, Add&& add) {
  OudbSweep<std::uint32_t> sweep;
  for_each_plane(std::span(evm.vertices),
                 [&](const ExtremeVertices<2>& plane, std::uint32_t a) { sweep.pass(plane, a, add); });
}

/// The planes that a thread sweeps, and the section before them.
struct Planes {
  std::span<const OrderedPoint<3>> vertices;
  ExtremeVertices<2> before;
};

/// A part of a sweep for the CUDB. Its first `inherited` boxes continue boxes of the part before.
struct Part {
  std::vector<OrdinalBox>
      boxes;  // hi[0] is kOrdinalMin if a box continues in the next part; so is lo[0] if inherited
  std::size_t inherited = 0;
  std::vector<std::uint32_t> open;  // boxes that continue, in the order in which the next part inherits them
};

/// Sweeps a part. A box lasts as long as its rectangle belongs to the section: as in CudbSweep, but in the
/// order in which boxes begin. Throws TooMany if there are more than `most` boxes.
Part sweep(const Planes& planes, std::uint64_t most) {
  using Rectangle = SectionRectangle<std::uint32_t>;
  Part part;
  SectionRectangles<std::uint32_t> rectangles;
  const auto begin = [&](const Rectangle& r, std::uint32_t a) {
    if (part.boxes.size() - part.inherited == most) throw TooMany();
    part.boxes.push_back({{a, r.b_lo, r.c_lo}, {Axis::kOrdinalMin, r.b_hi, r.c_hi}});
    return static_cast<std::uint32_t>(part.boxes.size() - 1);
  };
  const auto end = [&](const Rectangle& r, std::uint32_t a) { part.boxes[r.mark].hi[0] = a; };
  ExtremeVertices<3> inherited;
  inherited.reserve(planes.before.size());
  for (const auto& [b, c] : planes.before) inherited.push_back({Axis::kOrdinalMin, b, c});
  rectangles.pass(inherited, begin, end);
  part.inherited = part.boxes.size();
  rectangles.pass(planes.vertices, begin, end);
  for (const Rectangle& r : rectangles.all()) part.open.push_back(r.mark);
  return part;
}

/// The change of the section across the planes of some vertices: the symmetric difference of the planes.
ExtremeVertices<2> section_change(std::span<const OrderedPoint<3>> vertices) {
  ExtremeVertices<2> points;
  points.reserve(vertices.size());
  for (const OrderedPoint<3>& v : vertices) points.push_back({v[1], v[2]});
  radix_sort(std::span(points), PointKey());
  keep_odd(points);
  return points;
}

/// Cuts the sweep into parts of whole planes, one for each thread. No part begins where the section is much
/// larger than the part. All sections together therefore have at most twice as many vertices as the solid.
std::vector<Planes> cut_sweep(const Evm& evm) {
  constexpr std::size_t kLeastVertices = 1 << 14;
  const std::size_t wanted = std::clamp<std::size_t>(evm.vertices.size() / kLeastVertices, 1, thread_count());
  std::vector<std::span<const OrderedPoint<3>>> cuts;
  for (std::span<const OrderedPoint<3>> rest = evm.vertices; !rest.empty();) {
    std::size_t count = std::min(rest.size(), evm.vertices.size() / wanted + 1);
    while (count < rest.size() && rest[count][0] == rest[count - 1][0]) ++count;
    cuts.push_back(rest.first(count));
    rest = rest.subspan(count);
  }
  std::vector<ExtremeVertices<2>> changes(cuts.size());
  parallel_for_each(0, std::max<std::size_t>(cuts.size(), 1) - 1, 1,
                    [&](std::size_t i) { changes[i] = section_change(cuts[i]); });
  std::vector<Planes> parts;
  ExtremeVertices<2> section, next;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (i == 0 || section.size() <= 2 * cuts[i].size())
      parts.push_back({cuts[i], section});
    else
      parts.back().vertices = {parts.back().vertices.begin(), cuts[i].end()};
    exclusive_or(section, changes[i], next);
    std::swap(section, next);
    changes[i] = ExtremeVertices<2>();  // {} would keep the memory
  }
  return parts;
}

/// Sweeps all parts. Throws TooMany if a part finds more than `most` boxes.
std::vector<Part> sweep_in_parts(const Evm& evm, std::uint64_t most) {
  const std::vector<Planes> planes = cut_sweep(evm);
  std::vector<Part> parts(planes.size());
  parallel_for_each(0, planes.size(), 1, [&](std::size_t i) { parts[i] = sweep(planes[i], most); });
  return parts;
}

/// Appends the boxes of parts in order.
void join_parts(std::vector<Part> parts, std::vector<OrdinalBox>& boxes) {
  std::vector<std::uint32_t> open;  // by box that the next part inherits
  for (Part& part : parts) {
    const std::size_t shift = boxes.size() - part.inherited;
    if (part.boxes.size() + shift > kMostBoxes) throw_too_many();
    for (std::size_t i = 0; i < part.inherited; ++i) boxes[open[i]].hi[0] = part.boxes[i].hi[0];
    for (std::uint32_t& box : part.open) box = box < part.inherited ? open[box] : std::uint32_t(box + shift);
    open = std::move(part.open);
    boxes.insert(boxes.end(), part.boxes.begin() + std::ptrdiff_t(part.inherited), part.boxes.end());
    part.boxes = std::vector<OrdinalBox>();  // {} would keep the memory
  }
}

bool holds_int32(const Axis& axis) {
  if (!axis.is_lattice() || axis.exponent() < 0) return false;
  using Limits = std::numeric_limits<std::int32_t>;
  return axis.count() == 0 ||
         (axis.coordinate(1) >= Limits::min() && axis.coordinate(axis.count()) <= Limits::max());
}

}  // namespace

Decomposition decompose(const Evm& evm, BoxModel model) {
  validate(evm.order);
  Decomposition result{evm.axes, evm.order, {}};
  if (model == BoxModel::cudb) {
    try {
      join_parts(sweep_in_parts(evm, kMostBoxes), result.boxes);
    } catch (const TooMany&) {
      throw_too_many();
    }
  } else {
    const std::uint64_t count =
        count_boxes(evm, model, kMostBoxes);  // there may be far more boxes than vertices
    if (count > kMostBoxes) throw_too_many();
    with_memory("the decomposition", count * sizeof(OrdinalBox), [&] { result.boxes.reserve(count); });
    find_oudb(evm, [&](const OrderedPoint<3>& lo, const OrderedPoint<3>& hi) {
      result.boxes.push_back({lo, hi});
    });
  }
  return result;
}

std::uint64_t count_boxes(const Evm& evm, BoxModel model, std::uint64_t most) {
  std::uint64_t count = 0;
  try {
    if (model == BoxModel::oudb)
      find_oudb(evm, [&](const auto&, const auto&) {
        if (++count > most) throw TooMany();
      });
    else
      for (const Part& part : sweep_in_parts(evm, most)) count += part.boxes.size() - part.inherited;
  } catch (const TooMany&) {
    return most + 1;
  }
  return std::min(count, most + 1);
}

Evm make_evm_of_fewest_boxes(const Solid& solid, BoxModel model) {
  Evm best;
  for (std::uint64_t limit = 8 * solid.vertices.size();; limit *= 8) {
    std::uint64_t fewest = limit + 1;
    for (const AxisOrder& candidate : kAxisOrders) {
      Evm evm = make_evm(solid, candidate);
      const std::uint64_t count = count_boxes(evm, model, fewest - 1);
      if (count >= fewest) continue;
      fewest = count;
      best = std::move(evm);
    }
    if (fewest <= limit) return best;
    if (limit >> 32 != 0) return make_evm(solid, kAxisOrders[0]);  // decompose() throws the error
  }
}

Evm make_evm(const Decomposition& decomposition) {
  validate(decomposition.order);
  Evm evm{decomposition.axes, decomposition.order, {}};
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  Array<OrderedPoint<3>> corners;
  with_memory("the corners of all boxes", 8 * boxes.size() * sizeof(OrderedPoint<3>),
              [&] { corners.resize(8 * boxes.size()); });
  parallel_for_each(0, boxes.size(), 1 << 14, [&](std::size_t i) {
    for (std::size_t k = 0; k < 8; ++k) {
      const auto& [lo, hi] = boxes[i];
      corners[8 * i + k] = {k & 4 ? hi[0] : lo[0], k & 2 ? hi[1] : lo[1], k & 1 ? hi[2] : lo[2]};
    }
  });
  radix_sort(std::span(corners), PointKey());
  keep_odd(corners);
  evm.vertices.assign(corners.begin(), corners.end());
  return evm;
}

bool hold_int32(const Axes& axes) {
  return std::all_of(axes.begin(), axes.end(), holds_int32);
}

BoxSet to_boxes(const Decomposition& decomposition) {
  validate(decomposition.order);
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  std::array<std::size_t, 3> place{};  // where x, y, z are in the order
  for (std::size_t i = 0; i < 3; ++i) place[decomposition.order[i]] = i;
  const auto convert = [&]<class T>(std::vector<BoxOf<T>> result) {
    with_memory("the boxes", boxes.size() * sizeof(BoxOf<T>), [&] { result.resize(boxes.size()); });
    parallel_for_each(0, boxes.size(), 1 << 14, [&](std::size_t i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        result[i][axis] = T(decomposition.axes[axis].coordinate(boxes[i].lo[place[axis]]));
        result[i][axis + 3] = T(decomposition.axes[axis].coordinate(boxes[i].hi[place[axis]]));
      }
    });
    return BoxSet(std::move(result));
  };
  return hold_int32(decomposition.axes) ? convert(std::vector<IntegerBox>()) : convert(std::vector<Box>());
}

}  // namespace boxunion

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "boxunion/error.hpp"
#include "boxunion/rectangle.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/radix_sort.hpp"
#include "core/boxes/ordinals.hpp"

namespace boxunion {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxCount = 4294967294.0;  // 2^32 - 2 ordinals
constexpr std::size_t kGrain = 1 << 14;     // boxes

/// The lowest set bit of a finite double as a power of two; infinity for zero.
inline double lowest_bit(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t fraction = bits & ((std::uint64_t(1) << 52) - 1);
  const double rest = std::bit_cast<double>(bits & ~(fraction & -fraction));
  const double low = std::abs(x - rest);            // exact: all but one bit cancel
  const double bit = low == 0 ? std::abs(x) : low;  // without fraction bits, the leading bit is the only one
  return bit == 0 ? kInfinity : bit;
}

/// A third of a box, for compilers that do not vectorize.
using Pair = double __attribute__((vector_size(16)));
using Mask = std::int64_t __attribute__((vector_size(16)));

inline Pair absolute(Pair x) {
  constexpr std::int64_t kWithoutSign = std::numeric_limits<std::int64_t>::max();
  return Pair(Mask(x) & Mask{kWithoutSign, kWithoutSign});
}

/// The axes that are lattices for all boxes together. The others have no ordinals yet.
Axes lattices_of(std::span<const BoxSet> sets) {
  LatticeScan scan;
  for (const BoxSet& set : sets) scan.add(set);
  return scan.axes();
}

/// Packs selected elements of 0 .. size - 1 into an array, in order and in parallel. A first pass counts the
/// selected elements of each chunk, so that a second pass knows their places.
class Packing {
 public:
  /// wanted(i): true if element i is selected.
  template <class Wanted>
  Packing(std::size_t size, Wanted&& wanted) : size_(size), starts_((size + kGrain - 1) / kGrain + 1) {
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      std::size_t count = 0;
      for (std::size_t i = begin; i < end; ++i) count += wanted(i);
      starts_[chunk + 1] = count;
    });
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  }
  /// The number of selected elements.
  std::size_t count() const { return starts_.back(); }
  /// Calls f(begin, end, place) for ranges of elements. `place` is the number of selected elements before the
  /// range.
  template <class F>
  void each_range(F&& f) const {
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) { f(begin, end, starts_[chunk]); });
  }

 private:
  template <class F>
  void each_chunk(F&& f) const {
    parallel_for_each(0, starts_.size() - 1, 1, [&](std::size_t chunk) {
      f(chunk, chunk * kGrain, std::min(size_, (chunk + 1) * kGrain));
    });
  }

  std::size_t size_;
  std::vector<std::size_t> starts_;
};

/// The number of axes of boxes of any dimension, given as std::array of both corners.
template <class Boxes>
constexpr unsigned kAxesOf = std::tuple_size_v<typename Boxes::value_type> / 2;

/// Calls f(box, place) for every box that is not degenerate. `place` is the number of such boxes before it.
template <class Boxes>
class SolidBoxes {
 public:
  explicit SolidBoxes(const Boxes& boxes)
      : boxes_(boxes), packing_(boxes.size(), [&](std::size_t i) { return is_solid(boxes[i]); }) {}
  std::size_t count() const { return packing_.count(); }
  template <class F>
  void each(F&& f) const {
    packing_.each_range([&](std::size_t begin, std::size_t end, std::size_t place) {
      if (count() == boxes_.size())  // without branches
        for (std::size_t i = begin; i < end; ++i) f(boxes_[i], i);
      else
        for (std::size_t i = begin; i < end; ++i)
          if (is_solid(boxes_[i])) f(boxes_[i], place++);
    });
  }

 private:
  static bool is_solid(const auto& box) {
    bool solid = true;
    for (unsigned axis = 0; axis < kAxesOf<Boxes>; ++axis) solid &= box[axis] != box[axis + kAxesOf<Boxes>];
    return solid;
  }

  const Boxes& boxes_;
  Packing packing_;
};

/// The ordinals of boxes on the axes that have ordinals. Result is an array of structures with corners lo and
/// hi.
template <class Result, class Boxes, class AxesOfThem>
Result convert(const SolidBoxes<Boxes>& boxes, const AxesOfThem& axes) {
  Result result = with_memory("the boxes in ordinals", boxes.count() * sizeof(typename Result::value_type),
                              [&] { return Result(boxes.count()); });
  if (std::ranges::all_of(axes, [](const Axis& axis) { return axis.count() > 0 && axis.is_lattice(); })) {
    std::array<LatticeOrdinals, kAxesOf<Boxes>> ordinals;
    for (unsigned axis = 0; axis < kAxesOf<Boxes>; ++axis) ordinals[axis] = axes[axis].lattice_ordinals();
    boxes.each([ordinals, to = result.data()](const auto& box, std::size_t place) {
      for (unsigned axis = 0; axis < kAxesOf<Boxes>; ++axis) {
        to[place].lo[axis] = ordinals[axis](double(box[axis]));
        to[place].hi[axis] = ordinals[axis](double(box[axis + kAxesOf<Boxes>]));
      }
    });
    return result;
  }
  boxes.each([&](const auto& box, std::size_t place) {
    for (unsigned axis = 0; axis < kAxesOf<Boxes>; ++axis) {
      if (axes[axis].count() == 0) continue;
      result[place].lo[axis] = axes[axis].ordinal(double(box[axis]));
      result[place].hi[axis] = axes[axis].ordinal(double(box[axis + kAxesOf<Boxes>]));
    }
  });
  return result;
}

/// A coordinate and its origin.
struct Entry {
  std::uint64_t bits;   // ordered_bits of the coordinate
  std::uint64_t place;  // twice the place of the box, plus one for its high corner
};
/// The key of plain bits and of entries.
struct BitsOf {
  std::uint64_t operator()(std::uint64_t bits) const { return bits; }
  std::uint64_t operator()(const Entry& entry) const { return entry.bits; }
};

/// Sorts coordinates (plain bits or entries) and finds their ranks. Calls f(entry, ordinal) for each.
template <class T, class F>
Axis rank_of(std::span<T> entries, std::span<T> scratch, F&& f) {
  constexpr BitsOf bits_of;
  radix_sort(entries, scratch, bits_of);
  const auto is_new = [&](std::size_t i) { return i == 0 || bits_of(entries[i - 1]) != bits_of(entries[i]); };
  const Packing distinct(entries.size(), is_new);
  std::vector<double> coordinates(distinct.count());
  distinct.each_range([&](std::size_t begin, std::size_t end, std::size_t place) {
    for (std::size_t i = begin; i < end; ++i) {
      if (is_new(i)) coordinates[place++] = from_ordered_bits(bits_of(entries[i]));
      f(entries[i], static_cast<std::uint32_t>(place));
    }
  });
  return Axis::rank(std::move(coordinates));
}

template <class Boxes>
Axis rank_of(const Boxes& boxes, unsigned axis) {
  auto bits = make_array<std::uint64_t>(2 * boxes.size(), "sorting coordinates");
  auto scratch = make_array<std::uint64_t>(2 * boxes.size(), "sorting coordinates");
  parallel_for_each(0, boxes.size(), kGrain, [&](std::size_t i) {
    bits[2 * i] = ordered_bits(double(boxes[i][axis]));
    bits[2 * i + 1] = ordered_bits(double(boxes[i][axis + 3]));
  });
  return rank_of<std::uint64_t>(bits, scratch, [](std::uint64_t, std::uint32_t) {});
}

/// The same as convert(), but axes without ordinals become ranks.
template <class Result, class Boxes, class AxesOfThem>
Result convert_by_rank(const Boxes& all, AxesOfThem& axes) {
  const SolidBoxes boxes(all);
  Result result = convert<Result>(boxes, axes);
  auto entries = make_array<Entry>(2 * boxes.count(), "sorting coordinates");
  auto scratch = make_array<Entry>(2 * boxes.count(), "sorting coordinates");
  for (unsigned axis = 0; axis < kAxesOf<Boxes>; ++axis) {
    if (axes[axis].count() > 0) continue;
    boxes.each([&](const auto& box, std::size_t place) {
      entries[2 * place] = {ordered_bits(double(box[axis])), 2 * place};
      entries[2 * place + 1] = {ordered_bits(double(box[axis + kAxesOf<Boxes>])), 2 * place + 1};
    });
    axes[axis] = rank_of<Entry>(entries, scratch, [&](const Entry& entry, std::uint32_t ordinal) {
      auto& box = result[entry.place / 2];
      (entry.place % 2 == 0 ? box.lo : box.hi)[axis] = ordinal;
    });
  }
  return result;
}

Ordinals rank_boxes(const auto& all, const Axes& lattices) {
  Ordinals ordinals{lattices, {}, {}};
  ordinals.boxes = convert_by_rank<std::vector<OrdinalBox>>(all, ordinals.axes);
  return ordinals;
}

}  // namespace

void LatticeScan::Extent::join(const Extent& other) {
  lo = std::min(lo, other.lo);
  hi = std::max(hi, other.hi);
  unit = std::min(unit, other.unit);
}

// The unit of an axis is the least of all lowest bits, whatever the order of the boxes. It is slow to look at
// every bit, so each block is first tested against the units u found so far: if y = |x| equals (y + m) - m
// for m = 2^52 u, then x is a multiple of u.
//
// Proof. y + m >= 2^52 u, and doubles that large are multiples of u, so the rounded sum s is one. s - m is
// then a multiple of u, and so is its rounded value: below 2^53 u it is exact, and above all doubles are
// multiples of u. (With the sign of x, x + m could fall below 2^52 u, where doubles are multiples of u / 2
// only.) If m or the sum overflows, the test fails.
//
// A block that fails the test for any reason is looked at bit by bit, so the test only saves time.
template <unsigned kAxes>
LatticeScan LatticeScan::scan(const std::array<double, 2 * kAxes>* boxes, std::size_t count) {
  constexpr std::size_t kBlock = 128;
  double unit[2 * kAxes];
  std::fill(unit, unit + 2 * kAxes, kInfinity);
  Pair lo[kAxes], hi[kAxes];
  for (unsigned pair = 0; pair < kAxes; ++pair) {
    lo[pair] = Pair{kInfinity, kInfinity};
    hi[pair] = -lo[pair];
  }
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(count, begin + kBlock);
    Pair magic[kAxes];
    Mask same[kAxes];
    for (unsigned pair = 0; pair < kAxes; ++pair) {
      magic[pair] = Pair{unit[2 * pair], unit[2 * pair + 1]} * 0x1p52;
      same[pair] = Mask{-1, -1};
    }
    for (std::size_t i = begin; i < end; ++i)
      for (unsigned pair = 0; pair < kAxes; ++pair) {
        Pair x;
        std::memcpy(&x, boxes[i].data() + 2 * pair, sizeof x);
        const Pair size = absolute(x);
        same[pair] &= (size + magic[pair]) - magic[pair] == size;
        lo[pair] = x < lo[pair] ? x : lo[pair];
        hi[pair] = x > hi[pair] ? x : hi[pair];
      }
    Mask all = same[0];
    for (unsigned pair = 1; pair < kAxes; ++pair) all &= same[pair];
    if (all[0] && all[1]) continue;
    for (std::size_t i = begin; i < end; ++i)
      for (unsigned lane = 0; lane < 2 * kAxes; ++lane)
        unit[lane] = std::min(unit[lane], lowest_bit(boxes[i][lane]));
  }
  LatticeScan result;
  for (unsigned lane = 0; lane < 2 * kAxes; ++lane)
    result.extents_[lane % kAxes].join({lo[lane / 2][lane % 2], hi[lane / 2][lane % 2], unit[lane]});
  return result;
}

template <unsigned kAxes>
LatticeScan LatticeScan::scan(const std::array<std::int32_t, 2 * kAxes>* boxes, std::size_t count) {
  std::int32_t set[2 * kAxes] = {}, lo[kAxes], hi[kAxes];
  std::fill(lo, lo + kAxes, std::numeric_limits<std::int32_t>::max());
  std::fill(hi, hi + kAxes, std::numeric_limits<std::int32_t>::min());
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<std::int32_t, 2 * kAxes>& box = boxes[i];
    for (unsigned lane = 0; lane < 2 * kAxes; ++lane) set[lane] |= box[lane];
    for (unsigned axis = 0; axis < kAxes; ++axis) {
      lo[axis] = box[axis] < lo[axis] ? box[axis] : lo[axis];
      hi[axis] = box[axis + kAxes] > hi[axis] ? box[axis + kAxes] : hi[axis];
    }
  }
  LatticeScan result;
  for (unsigned axis = 0; axis < kAxes; ++axis) {
    const std::int64_t either = std::int64_t(set[axis]) | set[axis + kAxes];
    result.extents_[axis] = {double(lo[axis]), double(hi[axis]),
                             either ? double(either & -either) : kInfinity};
  }
  return result;
}

/// The lattice of an extent, or an axis without ordinals if it has too many steps.
///
/// Proof that base fits: 2^e = unit is the lowest bit of some coordinate c, so |c| < 2^(e + 53). All others
/// are less than 2^32 steps of 2^e away. So every coordinate is a multiple of 2^e below (2^53 + 2^32) * 2^e.
/// If there are too many steps, their number below may be inexact or infinite. But rounding is monotone, so
/// it is still at least 2^32 - 2. (It is never infinity - infinity: e < 0 if the scaled coordinates overflow,
/// and a lowest bit below 2^0 belongs to a coordinate below 2^53.)
Axis LatticeScan::lattice_of(const Extent& extent) {
  const int exponent = extent.unit == kInfinity ? 0 : std::ilogb(extent.unit);
  const double before = std::ldexp(1.0, -(exponent / 2));
  const double after = std::ldexp(1.0, -(exponent - exponent / 2));
  const double steps = (extent.hi * before - extent.lo * before) * after;
  if (!(steps < kMaxCount)) return {};
  const auto first = static_cast<std::int64_t>(extent.lo * before * after);
  return Axis::lattice(first - 1, exponent, static_cast<std::uint32_t>(steps) + 1);
}

template <unsigned kAxes, class Set>
LatticeScan LatticeScan::scan(const Set& set) {
  return set.visit([](const auto& boxes) {
    return parallel_reduce(
        0, boxes.size(), kGrain, LatticeScan(),
        [&](std::size_t begin, std::size_t end, LatticeScan before) {
          before.join(scan<kAxes>(boxes.data() + begin, end - begin));
          return before;
        },
        [](LatticeScan a, const LatticeScan& b) {
          a.join(b);
          return a;
        });
  });
}

void LatticeScan::add(const BoxSet& set) {
  join(scan<3>(set));
}

void LatticeScan::add(const RectangleSet& set) {
  join(scan<2>(set));
}

void LatticeScan::join(const LatticeScan& other) {
  for (unsigned axis = 0; axis < 3; ++axis) extents_[axis].join(other.extents_[axis]);
}

Axes LatticeScan::axes() const {
  if (extents_[0].lo > extents_[0].hi) return {};  // no box
  return {lattice_of(extents_[0]), lattice_of(extents_[1]), lattice_of(extents_[2])};
}

PlaneAxes LatticeScan::plane_axes() const {
  if (extents_[0].lo > extents_[0].hi) return {};  // no rectangle
  return {lattice_of(extents_[0]), lattice_of(extents_[1])};
}

Axis Axis::lattice(std::int64_t base, int exponent, std::uint32_t count) {
  Axis axis;
  axis.base_ = base;
  axis.exponent_ = exponent;
  axis.count_ = count;
  axis.lattice_ordinals_ = LatticeOrdinals(base, exponent);
  return axis;
}

Axis Axis::rank(std::vector<double> coordinates) {
  if (double(coordinates.size()) > kMaxCount)
    throw Error(ErrorKind::resources, "more than 2^32 - 2 distinct coordinates on one axis");
  Axis axis;
  axis.count_ = static_cast<std::uint32_t>(coordinates.size());
  axis.ranks_ = std::move(coordinates);
  return axis;
}

double Axis::lattice_coordinate(std::uint32_t ordinal) const {
  return std::ldexp(double(base_ + ordinal), exponent_);
}

std::uint32_t Axis::rank_ordinal(double coordinate) const {
  return static_cast<std::uint32_t>(std::lower_bound(ranks_.begin(), ranks_.end(), coordinate) -
                                    ranks_.begin()) +
         1;
}

std::optional<Axes> find_lattices(std::span<const BoxSet> sets) {
  const Axes axes = lattices_of(sets);
  if (std::ranges::any_of(axes, [](const Axis& axis) { return axis.count() == 0; })) return std::nullopt;
  return axes;
}

Axes make_axes(const BoxSet& set) {
  Axes axes = lattices_of({&set, 1});
  set.visit([&](const auto& boxes) {
    for (unsigned axis = 0; axis < 3; ++axis)
      if (axes[axis].count() == 0) axes[axis] = rank_of(boxes, axis);
  });
  return axes;
}

Axes make_rank_axes(const BoxSet& set) {
  return set.visit([](const auto& boxes) {
    return Axes{rank_of(boxes, 0), rank_of(boxes, 1), rank_of(boxes, 2)};
  });
}

std::vector<OrdinalBox> ordinal_boxes(const BoxSet& set, const Axes& axes) {
  return set.visit(
      [&](const auto& boxes) { return convert<std::vector<OrdinalBox>>(SolidBoxes(boxes), axes); });
}

Ordinals ordinal_boxes(std::span<const BoxSet> sets, const Axes& axes) {
  Ordinals ordinals{axes, {}, {}};
  for (const BoxSet& set : sets) {
    std::vector<OrdinalBox> boxes = ordinal_boxes(set, axes);
    if (ordinals.boxes.empty())
      ordinals.boxes = std::move(boxes);
    else
      ordinals.boxes.insert(ordinals.boxes.end(), boxes.begin(), boxes.end());
    ordinals.ends.push_back(ordinals.boxes.size());
  }
  return ordinals;
}

Ordinals make_ordinals(const BoxSet& set) {
  return make_ordinals({&set, 1});
}

Ordinals make_ordinals(std::span<const BoxSet> sets) {
  const Axes lattices = lattices_of(sets);
  if (std::ranges::all_of(lattices, [](const Axis& axis) { return axis.count() > 0; }))
    return ordinal_boxes(sets, lattices);
  if (sets.size() == 1) {
    Ordinals ordinals = sets[0].visit([&](const auto& boxes) { return rank_boxes(boxes, lattices); });
    ordinals.ends = {ordinals.boxes.size()};
    return ordinals;
  }
  std::vector<Box> all;
  std::vector<std::size_t> ends;
  for (const BoxSet& set : sets) {
    const std::size_t end = ends.empty() ? 0 : ends.back();
    ends.push_back(end + set.size() - count_degenerate(set));
    all.reserve(all.size() + set.size());
    for (std::size_t i = 0; i < set.size(); ++i) all.push_back(set[i]);
  }
  Ordinals ordinals = rank_boxes(all, lattices);
  ordinals.ends = std::move(ends);
  return ordinals;
}

PlaneOrdinals make_ordinals(const RectangleSet& set) {
  LatticeScan scan;
  scan.add(set);
  PlaneOrdinals ordinals{scan.plane_axes(), {}};
  const bool lattices = std::ranges::all_of(ordinals.axes, [](const Axis& axis) { return axis.count() > 0; });
  ordinals.rectangles = set.visit([&](const auto& rectangles) {
    using Result = Array<OrdinalRectangle>;
    return lattices ? convert<Result>(SolidBoxes(rectangles), ordinals.axes)
                    : convert_by_rank<Result>(rectangles, ordinals.axes);
  });
  return ordinals;
}

std::vector<std::uint32_t> distinct_ordinals(std::span<const OrdinalBox> boxes, int axis) {
  std::vector<std::uint32_t> ordinals(2 * boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    ordinals[2 * i] = boxes[i].lo[axis];
    ordinals[2 * i + 1] = boxes[i].hi[axis];
  }
  radix_sort(std::span(ordinals));
  ordinals.erase(std::unique(ordinals.begin(), ordinals.end()), ordinals.end());
  ordinals.shrink_to_fit();
  return ordinals;
}

void replace_by_positions(std::span<OrdinalBox> boxes, int axis, std::span<const std::uint32_t> distinct,
                          std::uint32_t first) {
  const auto position = [&](std::uint32_t ordinal) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(distinct, ordinal) - distinct.begin()) + first;
  };
  parallel_ranges(0, boxes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (OrdinalBox& box : boxes.subspan(begin, end - begin)) {
      box.lo[axis] = position(box.lo[axis]);
      box.hi[axis] = position(box.hi[axis]);
    }
  });
}

}  // namespace boxunion

#include "core/axis.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "core/memory.hpp"
#include "core/parallel.hpp"

namespace boxunion {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxCount = 4294967294.0;  // 2^32 - 2 ordinals
constexpr std::size_t kGrain = 1 << 14;     // boxes

/// What the coordinates of one axis have in common: their range, and the greatest power of two that divides
/// them all (infinity if they are all zero).
struct Extent {
  double lo = kInfinity, hi = -kInfinity, unit = kInfinity;

  void join(const Extent& other) {
    lo = std::min(lo, other.lo);
    hi = std::max(hi, other.hi);
    unit = std::min(unit, other.unit);
  }
};
using Extents = std::array<Extent, 3>;

/// The lowest set bit of a finite double as a power of two; infinity for zero.
inline double lowest_bit(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t fraction = bits & ((std::uint64_t(1) << 52) - 1);
  const double rest = std::bit_cast<double>(bits & ~(fraction & -fraction));
  const double low = std::abs(x - rest);            // exact: all but one bit cancel
  const double bit = low == 0 ? std::abs(x) : low;  // no fraction bit: the leading bit is the only one
  return bit == 0 ? kInfinity : bit;
}

/// A third of a box, for compilers that find no vectors by themselves.
using Pair = double __attribute__((vector_size(16)));
using Mask = std::int64_t __attribute__((vector_size(16)));

// Blocks are tested against the units found so far: adding and subtracting 1.5 * 2^52 units rounds to a
// multiple of the unit, so a coordinate that comes back unchanged is one. The few blocks that fail are looked
// at bit by bit.
Extents scan(const Box* boxes, std::size_t count) {
  constexpr std::size_t kBlock = 128;
  double unit[6];
  std::fill(unit, unit + 6, kInfinity);
  Pair lo[3], hi[3];
  for (unsigned pair = 0; pair < 3; ++pair) {
    lo[pair] = Pair{kInfinity, kInfinity};
    hi[pair] = -lo[pair];
  }
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(count, begin + kBlock);
    Pair magic[3];
    Mask same[3];
    for (unsigned pair = 0; pair < 3; ++pair) {
      magic[pair] = Pair{unit[2 * pair], unit[2 * pair + 1]} * 0x1.8p52;  // if infinite, none comes back
      same[pair] = Mask{-1, -1};
    }
    for (std::size_t i = begin; i < end; ++i)
      for (unsigned pair = 0; pair < 3; ++pair) {
        Pair x;
        std::memcpy(&x, boxes[i].data() + 2 * pair, sizeof x);
        same[pair] &= (x + magic[pair]) - magic[pair] == x;
        lo[pair] = x < lo[pair] ? x : lo[pair];
        hi[pair] = x > hi[pair] ? x : hi[pair];
      }
    const Mask all = same[0] & same[1] & same[2];
    if (all[0] && all[1]) continue;
    for (std::size_t i = begin; i < end; ++i)
      for (unsigned lane = 0; lane < 6; ++lane) unit[lane] = std::min(unit[lane], lowest_bit(boxes[i][lane]));
  }
  Extents extents;
  for (unsigned lane = 0; lane < 6; ++lane)
    extents[lane % 3].join({lo[lane / 2][lane % 2], hi[lane / 2][lane % 2], unit[lane]});
  return extents;
}

Extents scan(const IntegerBox* boxes, std::size_t count) {
  std::int32_t set[6] = {}, lo[3], hi[3];
  std::fill(lo, lo + 3, std::numeric_limits<std::int32_t>::max());
  std::fill(hi, hi + 3, std::numeric_limits<std::int32_t>::min());
  for (std::size_t i = 0; i < count; ++i) {
    const IntegerBox& box = boxes[i];
    for (unsigned lane = 0; lane < 6; ++lane) set[lane] |= box[lane];
    for (unsigned axis = 0; axis < 3; ++axis) {
      lo[axis] = box[axis] < lo[axis] ? box[axis] : lo[axis];
      hi[axis] = box[axis + 3] > hi[axis] ? box[axis + 3] : hi[axis];
    }
  }
  Extents extents;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const std::int64_t either = std::int64_t(set[axis]) | set[axis + 3];
    extents[axis] = {double(lo[axis]), double(hi[axis]), either ? double(either & -either) : kInfinity};
  }
  return extents;
}

/// The lattice of an extent, or an axis without ordinals if it has too many steps.
///
/// Proof that base fits: 2^e = unit is the lowest bit of some coordinate c, so |c| < 2^(e + 53); all others
/// are less than 2^32 steps of 2^e away, so every coordinate is a multiple of 2^e below (2^53 + 2^32) * 2^e.
/// The steps below may be inexact or infinite when there are too many, but rounding is monotone: they are
/// then at least 2^32 - 2 still. (Never infinity - infinity: e < 0 when the scaled coordinates overflow, and
/// a lowest bit below 2^0 belongs to a coordinate below 2^53.)
Axis lattice_of(const Extent& extent) {
  const int exponent = extent.unit == kInfinity ? 0 : std::ilogb(extent.unit);
  const double before = std::ldexp(1.0, -(exponent / 2));
  const double after = std::ldexp(1.0, -(exponent - exponent / 2));
  const double steps = (extent.hi * before - extent.lo * before) * after;
  if (!(steps < kMaxCount)) return {};
  const auto first = static_cast<std::int64_t>(extent.lo * before * after);
  return Axis::lattice(first - 1, exponent, static_cast<std::uint32_t>(steps) + 1);
}

template <class Boxes>
Axis rank_of(const Boxes& boxes, unsigned axis) {
  const std::size_t count = 2 * boxes.size();
  std::vector<double> coordinates = with_memory("sorting the coordinates", count * sizeof(double),
                                                [&] { return std::vector<double>(count); });
  parallel_ranges(0, boxes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      coordinates[2 * i] = double(boxes[i][axis]) + 0.0;  // -0.0 becomes 0.0
      coordinates[2 * i + 1] = double(boxes[i][axis + 3]) + 0.0;
    }
  });
  parallel_sort(coordinates.begin(), coordinates.end());
  coordinates.erase(std::unique(coordinates.begin(), coordinates.end()), coordinates.end());
  return Axis::rank(std::move(coordinates));
}

}  // namespace

Axis Axis::lattice(std::int64_t base, int exponent, std::uint32_t count) {
  Axis axis;
  axis.base_ = base;
  axis.exponent_ = exponent;
  axis.count_ = count;
  axis.scale_before_ = std::ldexp(1.0, -(exponent / 2));
  axis.scale_after_ = std::ldexp(1.0, -(exponent - exponent / 2));
  axis.first_ = std::ldexp(double(base + 1), exponent - exponent / 2);
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

double Axis::coordinate(std::uint32_t ordinal) const {
  return is_lattice() ? std::ldexp(double(base_ + ordinal), exponent_) : ranks_[ordinal - 1];
}

std::uint32_t Axis::rank_ordinal(double coordinate) const {
  return static_cast<std::uint32_t>(std::lower_bound(ranks_.begin(), ranks_.end(), coordinate) -
                                    ranks_.begin()) +
         1;
}

Axes make_axes(const BoxSet& set) {
  if (set.size() == 0) return {};
  return set.visit([](const auto& boxes) {
    const Extents extents = parallel_reduce(
        0, boxes.size(), kGrain, Extents{},
        [&](std::size_t begin, std::size_t end, Extents extents) {
          const Extents more = scan(boxes.data() + begin, end - begin);
          for (unsigned axis = 0; axis < 3; ++axis) extents[axis].join(more[axis]);
          return extents;
        },
        [](Extents a, const Extents& b) {
          for (unsigned axis = 0; axis < 3; ++axis) a[axis].join(b[axis]);
          return a;
        });
    Axes axes;
    for (unsigned axis = 0; axis < 3; ++axis) {
      axes[axis] = lattice_of(extents[axis]);
      if (axes[axis].count() == 0) axes[axis] = rank_of(boxes, axis);
    }
    return axes;
  });
}

Axes make_rank_axes(const BoxSet& set) {
  return set.visit([](const auto& boxes) {
    return Axes{rank_of(boxes, 0), rank_of(boxes, 1), rank_of(boxes, 2)};
  });
}

std::vector<OrdinalBox> ordinal_boxes(const BoxSet& set, const Axes& axes) {
  return set.visit([&](const auto& boxes) {
    const auto degenerate = [](const auto& box) {
      return box[0] == box[3] || box[1] == box[4] || box[2] == box[5];
    };
    const std::size_t chunks = (boxes.size() + kGrain - 1) / kGrain;
    const auto each_box = [&](std::size_t chunk, auto&& f) {
      const std::size_t end = std::min(boxes.size(), (chunk + 1) * kGrain);
      for (std::size_t i = chunk * kGrain; i < end; ++i)
        if (!degenerate(boxes[i])) f(boxes[i]);
    };
    // Where each chunk's boxes start in the result: count them, then sum the counts.
    std::vector<std::size_t> starts(chunks + 1);
    parallel_ranges(0, chunks, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t chunk = begin; chunk < end; ++chunk)
        each_box(chunk, [&](const auto&) { ++starts[chunk + 1]; });
    });
    std::partial_sum(starts.begin(), starts.end(), starts.begin());

    std::vector<OrdinalBox> result = with_memory("the boxes in ordinals", starts.back() * sizeof(OrdinalBox),
                                                 [&] { return std::vector<OrdinalBox>(starts.back()); });
    parallel_ranges(0, chunks, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t chunk = begin; chunk < end; ++chunk) {
        OrdinalBox* out = result.data() + starts[chunk];
        each_box(chunk, [&](const auto& box) {
          for (unsigned axis = 0; axis < 3; ++axis) {
            out->lo[axis] = axes[axis].ordinal(double(box[axis]));
            out->hi[axis] = axes[axis].ordinal(double(box[axis + 3]));
          }
          ++out;
        });
      }
    });
    return result;
  });
}

}  // namespace boxunion

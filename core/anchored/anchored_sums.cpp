#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "boxunion/octants.hpp"
#include "core/anchored/anchored.hpp"
#include "core/anchored/staircase.hpp"
#include "core/base/exact.hpp"
#include "core/base/parallel.hpp"
#include "core/base/radix_sort.hpp"
#include "core/solid/mass_totals.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kSumGrain = 1 << 13;  // boxes

/// A double as +-fraction * 2^(exponent - kBias). Zero has fraction 0.
struct Parts {
  explicit Parts(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto field = static_cast<int>(bits >> 52 & 0x7ff);
    fraction = (bits & ((std::uint64_t{1} << 52) - 1)) | std::uint64_t{field != 0} << 52;
    exponent = std::max(field, 1);
    negative = (bits >> 63) != 0;
  }
  static constexpr int kBias = 1075;

  std::uint64_t fraction;
  int exponent;
  bool negative;
};

/// The numbers on an axis as multiples of a unit: the free ends of the boxes and the end that they share.
struct Units {
  int unit = std::numeric_limits<int>::max(), top = 0;  // the bits of all of them: [unit, top)
  double least = std::numeric_limits<double>::infinity(), greatest = -least;

  void add(double x) {
    least = std::min(least, x);
    greatest = std::max(greatest, x);
    const Parts parts(x);
    if (parts.fraction == 0) return;
    unit = std::min(unit, parts.exponent + std::countr_zero(parts.fraction));
    top = std::max(top, parts.exponent + 53);
  }
  void join(const Units& other) {
    unit = std::min(unit, other.unit);
    top = std::max(top, other.top);
    least = std::min(least, other.least);
    greatest = std::max(greatest, other.greatest);
  }
  /// The number of bits of the greatest difference, or more than 127.
  int reach_bits() const {
    if (top == 0) return 0;
    if (top - unit > 126) return std::numeric_limits<int>::max();
    const UInt128 difference = count<UInt128>(greatest) - count<UInt128>(least);
    const auto high = static_cast<std::uint64_t>(difference >> 64);
    return high ? 64 + int(std::bit_width(high))
                : int(std::bit_width(static_cast<std::uint64_t>(difference)));
  }
  int exponent() const { return top == 0 ? 0 : unit - Parts::kBias; }

  /// x in units, modulo the size of K.
  template <class K>
  K count(double x) const {
    const Parts parts(x);
    const int shift = parts.exponent - unit;
    K value = 0;
    if (shift < 0)
      value = K(parts.fraction >> std::min(-shift, 63));
    else if (shift < int(8 * sizeof(K)))
      value = K(parts.fraction) << shift;
    return parts.negative ? K(0) - value : value;
  }
};

/// What the vertices of a column contribute: their number, and how often each height (in the order of
/// each_vertex), u and w counts in the edge length.
struct ColumnWeights {
  std::array<std::int8_t, 4> v{};
  std::int8_t u = 0, w = 0, vertices = 0, extreme = 0;
};

constexpr unsigned kColumns = 256;

/// A code of how the heights of a column compare. Heights grow inwards, except in the last column, and
/// downwards, except in the last plane.
constexpr unsigned column_kind(const StairColumn& c) {
  return unsigned(c.outer_above < c.inner_above) | unsigned(c.outer_above < c.outer_below) << 1 |
         unsigned(c.inner_above < c.inner_below) << 2 | unsigned(c.outer_below < c.inner_below) << 3 |
         unsigned(c.inner_above < c.outer_below) << 4 | unsigned(c.inner_above == c.outer_below) << 5 |
         unsigned(c.outer_above == 0) << 6 | unsigned(c.outer_below == 0) << 7;
}

constexpr std::array<ColumnWeights, kColumns> kColumnWeights = [] {
  std::array<ColumnWeights, kColumns> table{};
  const auto add = [&](const StairColumn& c) {
    ColumnWeights weights;
    each_vertex(c, [&](std::uint64_t v, unsigned mask) {
      const OctantProperties& point = kOctants[mask];
      const int height = v == c.inner_below ? 0 : v == c.outer_below ? 1 : v == c.inner_above ? 2 : 3;
      weights.v[unsigned(height)] = point.length[1];
      weights.u = std::int8_t(weights.u + point.length[0]);
      weights.w = std::int8_t(weights.w + point.length[2]);
      weights.vertices = std::int8_t(weights.vertices + 1);
      weights.extreme = std::int8_t(weights.extreme + int(point.extreme));
    });
    table[column_kind(c)] = weights;
  };
  for (unsigned heights = 0; heights < 5 * 5 * 5 * 5; ++heights) {
    const StairColumn c{0, heights % 5, heights / 5 % 5, heights / 25 % 5, heights / 125};
    const bool last_column = c.inner_above == 0 && c.inner_below == 0;
    const bool last_plane = c.outer_below == 0 && c.inner_below == 0;
    const bool inwards = c.outer_above <= c.inner_above && c.outer_below <= c.inner_below;
    const bool downwards = c.outer_above <= c.outer_below && c.inner_above <= c.inner_below;
    if ((last_column || inwards) && (last_plane || downwards)) add(c);
  }
  return table;
}();

/// Boxes with a common corner, and the units of their axes.
struct Anchored {
  CommonCorner corner;
  std::array<double, 3> at;
  std::array<Units, 3> units;
};

/// The integrals over the part of the union that one part of the sweep adds. They are in units and in u, v,
/// w, for reaches of at most kBits bits. An integral over a part of [0, 2^kBits)^3 has at most as many bits
/// as its factors together.
template <unsigned kBits>
class SumVisitor {
 public:
  /// Words that hold a product of so many factors.
  template <unsigned kFactors>
  using Product = Words<(kFactors * kBits + 63) / 64>;
  using Value = std::conditional_t<kBits <= 64, std::uint64_t, UInt128>;

  explicit SumVisitor(const Anchored& boxes) : axes_{Axis{boxes, 0}, Axis{boxes, 1}, Axis{boxes, 2}} {}

  /// The form of a box in the sweep.
  static AnchoredBox reach(const Anchored& boxes, const auto& box) {
    const auto on_axis = [&](unsigned a) -> std::uint64_t {
      const double far = double(box[boxes.corner[a] ? a : a + 3]);
      if constexpr (kBits <= 64) {
        const auto count = [&](double x) { return boxes.units[a].template count<Value>(x); };
        return boxes.corner[a] ? count(boxes.at[a]) - count(far) : count(far) - count(boxes.at[a]);
      } else {
        const std::uint64_t at = ordered_bits(boxes.at[a]), bits = ordered_bits(far);
        return boxes.corner[a] ? at - bits : bits - at;
      }
    };
    return {on_axis(0), on_axis(1), on_axis(2)};
  }
  Value value(unsigned axis, std::uint64_t reach) const { return axes_[axis].value(reach); }

  void column(const StairColumn& c) {
    // Slots change hands instead of values: 0 and 1 hold u, 2 and 3 heights above, 4 and 5 heights below. A
    // run of columns begins with equal heights; from there on, the heights below are new.
    const unsigned u = 1 - u_;
    set(powers_[u], 0, c.u);
    if (c.outer_above == c.outer_below)
      set(powers_[above_ = below_ = 2], 1, c.outer_above);
    else if (c.outer_above < c.outer_below)
      add_strip(powers_[u_], powers_[u], c);
    unsigned above = above_, below = below_;
    if (c.inner_above != c.outer_above) set(powers_[above = above_ == 2 ? 3 : 2], 1, c.inner_above);
    if (c.inner_below == c.inner_above)
      below = above;
    else if (c.inner_below != c.outer_below)
      set(powers_[below = below_ == 4 ? 5 : 4], 1, c.inner_below);

    const ColumnWeights& weights = kColumnWeights[column_kind(c)];
    vertices += std::uint64_t(weights.vertices);
    extreme += std::uint64_t(weights.extreme);
    along_w_ += weights.w;
    add_length(0, weights.u, powers_[u].value());
    const auto times = [&](unsigned i, unsigned slot) {
      return static_cast<Value>(weights.v[i]) * powers_[slot].value();
    };
    add_length(1, 1, times(0, below) + times(1, below_) + times(2, above) + times(3, above_));
    u_ = u, above_ = above, below_ = below;
  }

  void plane(std::uint64_t reach) {
    const Value value = axes_[2].value(reach);
    const Product<1> w = words(value);
    Product<3> volume_here{};
    Product<4> first_u{}, first_v{}, first_w{};
    add_product(volume_here, section_, w);
    add_product(first_u, section_u_, w);
    add_product(first_v, section_v_, w);
    add_product(first_w, volume_here, w);
    volume += volume_here;
    first[0] += first_u;
    first[1] += first_v;
    first[2] += first_w;
    add_product(second[0], section_uu_, w);
    add_product(second[1], section_vv_, w);
    add_product(second[2], first_w, w);
    add_product(second[3], section_uv_, w);
    add_product(second[4], first_v, w);
    add_product(second[5], first_u, w);
    add_product(area[0], side_v_, w);
    add_product(area[1], side_u_, w);
    area[2] += section_;
    add_length(2, std::exchange(along_w_, 0), value);
    section_ = {}, section_u_ = {}, section_v_ = {}, section_uu_ = {}, section_uv_ = {}, section_vv_ = {};
    side_u_ = {}, side_v_ = {};
  }

  SumVisitor& operator+=(const SumVisitor& other) {
    vertices += other.vertices;
    extreme += other.extreme;
    volume += other.volume;
    for (unsigned i = 0; i < 6; ++i) second[i] += other.second[i];
    for (unsigned a = 0; a < 3; ++a) {
      first[a] += other.first[a];
      area[a] += other.area[a];
      for (unsigned word = 0; word < kWords; ++word) length[a][word] += other.length[a][word];
    }
    return *this;
  }

  static constexpr unsigned kWords = sizeof(Value) / 8;
  std::uint64_t vertices = 0, extreme = 0;
  Product<3> volume{};
  std::array<Product<4>, 3> first{};   // twice the integrals of u, v, w
  std::array<Product<5>, 6> second{};  // 3 times those of uu, vv, ww, 4 times those of uv, vw, wu
  std::array<Product<2>, 3> area{};    // half of each area
  std::array<std::array<Int128, kWords>, 3> length{};  // a sum for each word

 private:
  /// An axis of the sweep.
  class Axis {
   public:
    Axis(const Anchored& boxes, unsigned axis)
        : units_(boxes.units[axis]),
          upper_(boxes.corner[axis]),
          bits_(ordered_bits(boxes.at[axis])),
          at_(units_.template count<Value>(boxes.at[axis])) {}
    Value value(std::uint64_t reach) const {
      if constexpr (kBits <= 64) return reach;
      const Value far =
          units_.template count<Value>(from_ordered_bits(upper_ ? bits_ - reach : bits_ + reach));
      return upper_ ? at_ - far : far - at_;
    }

   private:
    Units units_;
    bool upper_;
    std::uint64_t bits_;  // of the shared corner
    Value at_;
  };

  static Product<1> words(Value value) {
    if constexpr (kBits <= 64)
      return {value};
    else
      return {static_cast<std::uint64_t>(value), static_cast<std::uint64_t>(value >> 64)};
  }

  /// A reach and its powers.
  struct Powers {
    Product<1> one;
    Product<2> two;
    Product<3> three;

    Value value() const {
      if constexpr (kBits <= 64)
        return one[0];
      else
        return Value(one[1]) << 64 | one[0];
    }
  };
  void set(Powers& powers, unsigned axis, std::uint64_t reach) const {
    powers.one = words(axes_[axis].value(reach));
    powers.two = {}, powers.three = {};
    add_product(powers.two, powers.one, powers.one);
    add_product(powers.three, powers.two, powers.one);
  }

  /// Adds the strip by which the staircase was raised between two columns.
  void add_strip(const Powers& from, const Powers& to, const StairColumn& c) {
    const Powers &low = powers_[above_], &high = powers_[below_];
    const auto u1 = from.one - to.one, v1 = high.one - low.one;
    const auto u2 = from.two - to.two, v2 = high.two - low.two;
    add_product(section_, u1, v1);
    add_product(section_u_, u2, v1);
    add_product(section_v_, u1, v2);
    add_product(section_uu_, from.three - to.three, v1);
    add_product(section_uv_, u2, v2);
    add_product(section_vv_, u1, high.three - low.three);
    if (c.outer_above == 0) side_u_ += u1;
    if (c.u == 0) side_v_ += v1;
  }

  void add_length(unsigned axis, int times, Value value) {
    for (unsigned word = 0; word < kWords; ++word)
      length[axis][word] +=
          Int128(times) * static_cast<std::uint64_t>(value >> (word * (kBits <= 64 ? 0 : 64)));
  }

  std::array<Axis, 3> axes_;
  std::array<Powers, 6> powers_{};
  unsigned u_ = 0, above_ = 2, below_ = 2;  // of the last column, on its inner side
  // of the strips raised in the current plane; named as volume, first and second
  Product<2> section_{};
  Product<3> section_u_{}, section_v_{};
  Product<4> section_uu_{}, section_uv_{}, section_vv_{};
  Product<1> side_u_{}, side_v_{};  // how far the greatest reaches have grown
  int along_w_ = 0;                 // edges that end here, less those that begin
};

template <std::size_t N>
BigInteger integer(const Words<N>& words) {
  BigInteger result;
  import_bits(result, words.begin(), words.end(), 64, false);
  return result;
}

/// Converts integrals in u, v, w to integrals in coordinates: x = t + s * u.
template <unsigned kBits>
Totals in_coordinates(const SumVisitor<kBits>& sums, const Anchored& boxes) {
  std::array<Dyadic, 3> t;
  std::array<int, 3> s, e;
  for (unsigned a = 0; a < 3; ++a) {
    t[a] = dyadic(boxes.at[a]);
    s[a] = boxes.corner[a] ? -1 : 1;
    e[a] = boxes.units[a].exponent();
  }
  Totals totals;
  const auto local = [&](unsigned sum, const BigInteger& value) {
    return Dyadic{value, product_exponent(sum, e)};
  };
  const Dyadic volume = local(kVolume, integer(sums.volume));
  std::array<Dyadic, 3> first;  // s * 2 u
  for (unsigned a = 0; a < 3; ++a) first[a] = s[a] * local(kFirst + a, integer(sums.first[a]));
  totals[kVolume] = volume;
  for (unsigned a = 0; a < 3; ++a) {
    const unsigned b = (a + 1) % 3;
    totals[kFirst + a] = first[a] + 2 * (t[a] * volume);
    totals[kSecond + a] =
        local(kSecond + a, integer(sums.second[a])) + 3 * (t[a] * (first[a] + t[a] * volume));
    totals[kSecond + 3 + a] = (s[a] * s[b]) * local(kSecond + 3 + a, integer(sums.second[3 + a])) +
                              2 * (t[b] * first[a] + t[a] * first[b]) + 4 * (t[a] * t[b] * volume);
    totals[kArea + a] = 2 * local(kArea + a, integer(sums.area[a]));
    BigInteger length = 0;
    for (unsigned word = sums.kWords; word-- > 0;) length = (length << 64) + sums.length[a][word];
    totals[kLength + a] = local(kLength + a, length);
  }
  return totals;
}

/// The sums of boxes whose reaches have at most kBits bits.
template <unsigned kBits>
MassTotals sum(const auto& boxes, const Anchored& anchored) {
  using Visitor = SumVisitor<kBits>;
  auto result = std::make_unique<MassTotals::Sums>();
  auto reaches = make_array<AnchoredBox>(boxes.size(), "boxes with a common corner");
  parallel_for_each(0, boxes.size(), kSumGrain,
                    [&](std::size_t i) { reaches[i] = Visitor::reach(anchored, boxes[i]); });
  const StairSweep sweep(std::move(reaches));
  if (sweep.size() == 0) return MassTotals(std::move(result));
  std::vector<Visitor> visitors(sweep.parts(), Visitor(anchored));
  sweep.sweep(std::span(visitors));
  for (std::size_t i = 1; i < visitors.size(); ++i) visitors[0] += visitors[i];
  result->totals = in_coordinates(visitors[0], anchored);
  result->vertices = visitors[0].vertices;
  result->extreme = visitors[0].extreme;
  const std::array<std::uint64_t, 3> reach{sweep.bounds().u, sweep.bounds().v, sweep.bounds().w};
  for (unsigned a = 0; a < 3; ++a) {
    const BigInteger steps(visitors[0].value(a, reach[a]));
    const double far =
        round_to_double(dyadic(anchored.at[a]) + Dyadic{anchored.corner[a] ? BigInteger(-steps) : steps,
                                                        anchored.units[a].exponent()});
    result->lo[a] = std::min(far, anchored.at[a]) + 0.0;
    result->hi[a] = std::max(far, anchored.at[a]) + 0.0;
  }
  return MassTotals(std::move(result));
}

/// The units of the axes.
std::array<Units, 3> find_units(const auto& boxes, const CommonCorner& corner) {
  using All = std::array<Units, 3>;
  All units = parallel_reduce(
      0, boxes.size(), kSumGrain, All(),
      [&](std::size_t begin, std::size_t end, All before) {
        for (std::size_t i = begin; i < end; ++i)
          for (unsigned a = 0; a < 3; ++a) before[a].add(double(boxes[i][corner[a] ? a : a + 3]));
        return before;
      },
      [](All a, const All& b) {
        for (unsigned axis = 0; axis < 3; ++axis) a[axis].join(b[axis]);
        return a;
      });
  for (unsigned a = 0; a < 3; ++a) units[a].add(double(boxes[0][corner[a] ? a + 3 : a]));
  return units;
}

}  // namespace

std::optional<MassTotals> sum_anchored(const BoxSet& set, const CommonCorner& corner) {
  return set.visit([&](const auto& boxes) -> std::optional<MassTotals> {
    Anchored anchored{corner, {}, find_units(boxes, corner)};
    int bits = 0;
    for (unsigned a = 0; a < 3; ++a) {
      anchored.at[a] = double(boxes[0][corner[a] ? a + 3 : a]);
      bits = std::max(bits, anchored.units[a].reach_bits());
    }
    if (bits <= 64) return sum<64>(boxes, anchored);
    if (bits <= 80) return sum<80>(boxes, anchored);
    if (bits <= 127) return sum<127>(boxes, anchored);
    return std::nullopt;
  });
}

}  // namespace boxunion

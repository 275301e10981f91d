#include "core/solid/mass_sink.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/exact.hpp"
#include "core/base/parallel.hpp"
#include "core/solid/mass_totals.hpp"

namespace boxunion {
namespace {

/// Number of vertices and bounds, in ordinals.
struct Tally {
  std::uint64_t vertices = 0, extreme = 0;
  std::array<std::uint32_t, 3> lo{Axis::kOrdinalMax, Axis::kOrdinalMax, Axis::kOrdinalMax}, hi{};

  void extend(const std::array<std::uint32_t, 3>& low, const std::array<std::uint32_t, 3>& high) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      lo[axis] = std::min(lo[axis], low[axis]);
      hi[axis] = std::max(hi[axis], high[axis]);
    }
  }
  void join(const Tally& other) {
    vertices += other.vertices;
    extreme += other.extreme;
    extend(other.lo, other.hi);
  }
};

/// The sums of one thread on three lattices, in ordinals. Narrow: every ordinal is below 2^20.
template <bool kNarrow>
class LatticeSum {
 public:
  static constexpr std::uint32_t kNarrowCount = 1u << 20;

  explicit LatticeSum(const Axes& axes) {
    for (unsigned sum = 0; sum < kSums; ++sum)
      exponents_[sum] = product_exponent(sum, {axes[0].exponent(), axes[1].exponent(), axes[2].exponent()});
  }

  void add(std::span<const Vertex> vertices, Tally& tally) {
    for (; vertices.size() > kBlock; vertices = vertices.subspan(kBlock))
      add_block(vertices.first(kBlock), tally);
    add_block(vertices, tally);
  }

  // Moves the origin of the region's moments to its centre, modulo 2^64, and from there to ordinal 0: x
  // becomes x + o in 2x, 3xx and 4xy. About the centre of [0, 2c]^3, the integral of 3xx is between 0 and 8
  // c^5 = 2^63, and those of 4xy are between -2^62 and 2^62.
  void add(const LatticeSums& region, const std::array<std::uint32_t, 3>& origin) {
    constexpr std::int64_t c = LatticeSums::kMostEdge / 2;
    make_room(1);
    const Int128 volume = region.volume;
    sums_[kVolume].add(volume, 1);
    const auto first = [&](unsigned a) { return region.first[a] - 2 * c * region.volume; };
    const auto modulo = [](Int128 x) { return static_cast<std::uint64_t>(x); };
    for (unsigned a = 0; a < 3; ++a) {
      const unsigned b = (a + 1) % 3;
      const std::uint64_t oa = std::uint64_t(origin[a]) + c, ob = std::uint64_t(origin[b]) + c;
      const std::uint64_t square = modulo(region.second[a] - 3 * c * (Int128(first(a)) + c * volume));
      const std::uint64_t mixed =
          modulo(region.second[3 + a] - 2 * c * (Int128(first(a)) + first(b) + 2 * c * volume));
      sums_[kFirst + a].add(first(a), 1);
      sums_[kFirst + a].add(2 * volume, oa);
      sums_[kSecond + a].add(square >> 1, 2);  // in halves, because 2^63 does not fit std::int64_t
      sums_[kSecond + a].add(square & 1, 1);
      sums_[kSecond + a].add(first(a), 3 * oa);
      sums_[kSecond + a].add(3 * volume, oa * oa);
      sums_[kSecond + 3 + a].add(static_cast<std::int64_t>(mixed), 1);
      sums_[kSecond + 3 + a].add(first(a), 2 * ob);
      sums_[kSecond + 3 + a].add(first(b), 2 * oa);
      sums_[kSecond + 3 + a].add(4 * volume, oa * ob);
      sums_[kArea + a].add(region.area[a], 1);
      sums_[kLength + a].add(region.length[a], 1);
    }
  }

  void add_to(Totals& totals) const {
    for (unsigned sum = 0; sum < kSums; ++sum)
      totals[sum] = totals[sum] + Dyadic{totals_[sum] + sums_[sum].total(), exponents_[sum]};
  }

 private:
  static constexpr std::uint32_t kBlock = 1u << 20;

  void make_room(std::size_t addends) {
    pending_ += addends;
    if (pending_ <= kBlock) return;
    for (unsigned sum = 0; sum < kSums; ++sum) totals_[sum] += std::exchange(sums_[sum], {}).total();
    pending_ = addends;
  }

  void add_block(std::span<const Vertex> vertices, Tally& tally) {
    make_room(vertices.size());
    auto sums = sums_;  // a local copy, so that the compiler knows that nobody else reads it
    for (const Vertex& v : vertices) {
      const OctantProperties& weights = kOctants[v.mask];
      const std::array<std::uint64_t, 3> x{v.x, v.y, v.z};
      // at most 4 * 2^96, or 4 * 2^60 if narrow
      using Product = std::conditional_t<kNarrow, std::int64_t, Int128>;
      const Product volume = Product(weights.volume) * Product(x[0] * x[1]) * Product(x[2]);
      sums[kVolume].add(volume, 1);
      for (unsigned a = 0; a < 3; ++a) {
        const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
        sums[kFirst + a].add(volume, x[a]);
        sums[kSecond + a].add(volume, x[a] * x[a]);
        sums[kSecond + 3 + a].add(volume, x[a] * x[b]);
        sums[kArea + a].add(weights.area[a], x[b] * x[c]);
        sums[kLength + a].add(weights.length[a], x[a]);
      }
      tally.extreme += weights.extreme;
      tally.extend({v.x, v.y, v.z}, {v.x, v.y, v.z});
    }
    sums_ = sums;
    tally.vertices += vertices.size();
  }

  std::array<ProductSum<kNarrow>, kSums> sums_;
  std::array<BigInteger, kSums> totals_;  // overflow of sums_
  std::size_t pending_ = 0;
  std::array<int, kSums> exponents_;
};

/// A coordinate as +-magnitude * 2^(least exponent of the axis + 8 * place); magnitude < 2^61.
struct Significand {
  std::uint64_t magnitude;
  bool negative;
  unsigned place;
};

/// An axis of any kind, as significands.
class SignificandAxis {
 public:
  explicit SignificandAxis(const Axis& axis) : axis_(axis) {
    least_ = axis.is_lattice() ? axis.exponent() : 0;
    if (axis.is_lattice()) return;
    // Coordinates ascend, so the extreme exponents are at the ends and on both sides of zero.
    std::uint32_t after_negative = 1;
    for (std::uint32_t end = axis.count() + 1; after_negative < end;) {
      const std::uint32_t middle = after_negative + (end - after_negative) / 2;
      if (axis.coordinate(middle) < 0)
        after_negative = middle + 1;
      else
        end = middle;
    }
    int least = std::numeric_limits<int>::max(), greatest = std::numeric_limits<int>::min();
    for (const std::uint32_t ordinal :
         {std::uint32_t(1), after_negative - 1, after_negative, after_negative + 1, axis.count()}) {
      if (ordinal < 1 || ordinal > axis.count() || axis.coordinate(ordinal) == 0) continue;
      const int exponent = exponent_of(std::bit_cast<std::uint64_t>(axis.coordinate(ordinal)));
      least = std::min(least, exponent);
      greatest = std::max(greatest, exponent);
    }
    if (least > greatest) return;
    least_ = least;
    max_place_ = static_cast<unsigned>(greatest - least) / PlacedSum::kPlaceBits;
  }

  int least_exponent() const { return least_; }
  unsigned max_place() const { return max_place_; }

  Significand operator[](std::uint32_t ordinal) const {
    if (axis_.is_lattice()) {
      const std::int64_t steps = axis_.base() + ordinal;
      return {static_cast<std::uint64_t>(steps < 0 ? -steps : steps), steps < 0, 0};
    }
    const auto bits = std::bit_cast<std::uint64_t>(axis_.coordinate(ordinal));
    const std::uint64_t fraction = bits & (kLeadingBit - 1);
    const bool subnormal = (bits >> 52 & 0x7ff) == 0;
    if (subnormal && fraction == 0) return {0, false, 0};  // zero has no exponent
    const auto offset = static_cast<unsigned>(exponent_of(bits) - least_);
    return {(subnormal ? fraction : fraction | kLeadingBit) << offset % PlacedSum::kPlaceBits,
            (bits >> 63) != 0, offset / PlacedSum::kPlaceBits};
  }

 private:
  static constexpr std::uint64_t kLeadingBit = std::uint64_t(1) << 52;

  /// The exponent of the lowest bit of the fraction.
  static int exponent_of(std::uint64_t bits) {
    return std::max(static_cast<int>(bits >> 52 & 0x7ff), 1) - 1075;
  }

  const Axis& axis_;
  int least_;
  unsigned max_place_ = 0;
};

/// The sums of one thread on axes of any kind, in coordinates.
class GeneralSum {
 public:
  explicit GeneralSum(const Axes& axes)
      : axes_{SignificandAxis(axes[0]), SignificandAxis(axes[1]), SignificandAxis(axes[2])} {
    for (unsigned sum = 0; sum < kSums; ++sum) {
      unsigned max_place = 0, factors = 0;
      for (unsigned a = 0; a < 3; ++a) {
        const auto power = static_cast<unsigned>(kPowers[sum][a]);
        max_place += power * axes_[a].max_place();
        factors += power;
      }
      const int exponent = product_exponent(
          sum, {axes_[0].least_exponent(), axes_[1].least_exponent(), axes_[2].least_exponent()});
      sums_.emplace_back(exponent, max_place, factors);
    }
  }

  void add(std::span<const Vertex> vertices, Tally& tally) {
    for (const Vertex& v : vertices) {
      const OctantProperties& weights = kOctants[v.mask];
      const std::array<Significand, 3> x{axes_[0][v.x], axes_[1][v.y], axes_[2][v.z]};
      if (weights.volume != 0) add_volume(weights.volume, x);
      for (unsigned a = 0; a < 3; ++a) {
        const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
        if (weights.area[a] != 0)
          sums_[kArea + a].add(weighted(weights.area[a], x[b]) * x[c].magnitude,
                               (weights.area[a] < 0) != (x[b].negative != x[c].negative),
                               x[b].place + x[c].place);
        if (weights.length[a] != 0)
          sums_[kLength + a].add(weighted(weights.length[a], x[a]), (weights.length[a] < 0) != x[a].negative,
                                 x[a].place);
      }
      tally.extreme += weights.extreme;
      tally.extend({v.x, v.y, v.z}, {v.x, v.y, v.z});
    }
    tally.vertices += vertices.size();
  }

  void add(const LatticeSums&, const std::array<std::uint32_t, 3>&) {
    throw Error(ErrorKind::usage, "sums of a region need three lattice axes");
  }

  void add_to(Totals& totals) const {
    for (unsigned sum = 0; sum < kSums; ++sum) totals[sum] = totals[sum] + sums_[sum].total();
  }

 private:
  // Weights are at most 4, so the product still fits one word.
  static Words<1> weighted(int weight, const Significand& x) {
    return {static_cast<std::uint64_t>(weight < 0 ? -weight : weight) * x.magnitude};
  }

  void add_volume(int weight, const std::array<Significand, 3>& x) {
    const Words<3> volume = weighted(weight, x[0]) * x[1].magnitude * x[2].magnitude;
    const bool negative = (weight < 0) != ((x[0].negative != x[1].negative) != x[2].negative);
    const unsigned place = x[0].place + x[1].place + x[2].place;
    sums_[kVolume].add(volume, negative, place);
    for (unsigned a = 0; a < 3; ++a) {
      const unsigned b = (a + 1) % 3;
      const Words<4> first = volume * x[a].magnitude;
      const bool first_negative = negative != x[a].negative;
      const unsigned first_place = place + x[a].place;
      sums_[kFirst + a].add(first, first_negative, first_place);
      sums_[kSecond + a].add(first * x[a].magnitude, negative, first_place + x[a].place);
      sums_[kSecond + 3 + a].add(first * x[b].magnitude, first_negative != x[b].negative,
                                 first_place + x[b].place);
    }
  }

  std::array<SignificandAxis, 3> axes_;
  std::vector<PlacedSum> sums_;
};

/// All sums of one thread.
template <class Sum>
struct Share {
  Sum sum;
  Tally tally;
};

template <class Sum>
using Shares = PerThread<Share<Sum>>;
using AnyShares = std::variant<Shares<LatticeSum<true>>, Shares<LatticeSum<false>>, Shares<GeneralSum>>;

AnyShares make_shares(const Axes& axes) {
  const auto all = [&](auto&& test) { return std::all_of(axes.begin(), axes.end(), test); };
  const auto shares = [&]<class Sum>(std::in_place_type_t<Sum>) {
    return AnyShares(std::in_place_type<Shares<Sum>>, Share<Sum>{Sum(axes), {}});
  };
  if (!all([](const Axis& axis) { return axis.is_lattice(); })) return shares(std::in_place_type<GeneralSum>);
  if (!all([](const Axis& axis) { return axis.count() < LatticeSum<true>::kNarrowCount; }))
    return shares(std::in_place_type<LatticeSum<false>>);
  return shares(std::in_place_type<LatticeSum<true>>);
}

/// Moves the origin of the moments of `totals` to that of the coordinates, if they count from ordinal 0 of
/// lattices: x becomes x + b in 2x, 3xx and 4xy.
void move_to_coordinates(Totals& totals, const Axes& axes) {
  const Totals local = totals;
  const Dyadic& volume = local[kVolume];
  for (unsigned a = 0; a < 3; ++a) {
    const unsigned b = (a + 1) % 3;
    const Dyadic at_a{axes[a].base(), axes[a].exponent()}, at_b{axes[b].base(), axes[b].exponent()};
    const Dyadic &first_a = local[kFirst + a], &first_b = local[kFirst + b];
    totals[kFirst + a] = first_a + 2 * (at_a * volume);
    totals[kSecond + a] = local[kSecond + a] + 3 * (at_a * (first_a + at_a * volume));
    totals[kSecond + 3 + a] =
        local[kSecond + 3 + a] + 2 * (at_b * first_a + at_a * first_b) + 4 * (at_a * at_b * volume);
  }
}

}  // namespace

struct MassSink::Sums {
  explicit Sums(Axes a) : axes(std::move(a)), shares(make_shares(axes)) {}
  Axes axes;
  AnyShares shares;
};

MassSink::MassSink(Axes axes) : sums_(std::make_unique<Sums>(std::move(axes))) {}
MassSink::~MassSink() = default;

void MassSink::add(std::span<const Vertex> vertices) {
  std::visit(
      [&](auto& shares) {
        auto& mine = shares.local();
        mine.sum.add(vertices, mine.tally);
      },
      sums_->shares);
}

void MassSink::add(const LatticeSums& sums, const std::array<std::uint32_t, 3>& origin) {
  std::visit(
      [&](auto& shares) {
        auto& mine = shares.local();
        mine.sum.add(sums, origin);
        mine.tally.vertices += sums.vertices;
        mine.tally.extreme += sums.extreme;
      },
      sums_->shares);
}

void MassSink::extend_bounds(const OrdinalBox& box) {
  std::visit([&](auto& shares) { shares.local().tally.extend(box.lo, box.hi); }, sums_->shares);
}

MassTotals MassSink::totals() const {
  const Axes& axes = sums_->axes;
  MassTotals result;
  MassTotals::Sums& all = *result.sums_;
  Tally tally;
  std::visit(
      [&](const auto& shares) {
        shares.for_each([&](const auto& share) {
          share.sum.add_to(all.totals);
          tally.join(share.tally);
        });
      },
      sums_->shares);
  if (!std::holds_alternative<Shares<GeneralSum>>(sums_->shares)) move_to_coordinates(all.totals, axes);
  all.vertices = tally.vertices;
  all.extreme = tally.extreme;
  for (unsigned a = 0; a < 3; ++a)
    if (tally.lo[a] <= tally.hi[a])
      all.lo[a] = axes[a].coordinate(tally.lo[a]), all.hi[a] = axes[a].coordinate(tally.hi[a]);
  return result;
}

MassTotals::MassTotals() : sums_(std::make_unique<Sums>()) {}
MassTotals::MassTotals(std::unique_ptr<Sums> sums) : sums_(std::move(sums)) {}
MassTotals::MassTotals(MassTotals&&) noexcept = default;
MassTotals& MassTotals::operator=(MassTotals&&) noexcept = default;
MassTotals::~MassTotals() = default;

MassTotals& MassTotals::operator+=(const MassTotals& other) {
  sums_->vertices += other.sums_->vertices;
  sums_->extreme += other.sums_->extreme;
  for (unsigned a = 0; a < 3; ++a) {
    sums_->lo[a] = std::min(sums_->lo[a], other.sums_->lo[a]);
    sums_->hi[a] = std::max(sums_->hi[a], other.sums_->hi[a]);
  }
  for (unsigned sum = 0; sum < kSums; ++sum)
    sums_->totals[sum] = sums_->totals[sum] + other.sums_->totals[sum];
  return *this;
}

MassProperties MassTotals::result() const {
  const Totals& totals = sums_->totals;
  MassProperties p;
  p.vertices = sums_->vertices;
  p.extreme_vertices = sums_->extreme;
  for (unsigned a = 0; a < 3; ++a)
    if (sums_->lo[a] <= sums_->hi[a]) p.bounds[0][a] = sums_->lo[a], p.bounds[1][a] = sums_->hi[a];
  p.volume = round_to_double(totals[kVolume]);
  p.area = round_to_double(totals[kArea] + totals[kArea + 1] + totals[kArea + 2]);
  p.edge_length = round_to_double(totals[kLength] + totals[kLength + 1] + totals[kLength + 2]);

  // The integrals of x and so on are first / 2, second / 3 (xx) and second / 4 (xy).
  const Dyadic& volume = totals[kVolume];
  if (volume.m == 0) return p;
  const Dyadic* first = &totals[kFirst];
  const Dyadic* second = &totals[kSecond];
  for (unsigned a = 0; a < 3; ++a) {
    p.centroid[a] = round_quotient(first[a], 2 * volume);

    // About the centroid: xx = second / 3 - (first / 2)^2 / volume, and likewise xy.
    const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
    p.inertia[a][a] = round_quotient(
        4 * (volume * (second[b] + second[c])) - 3 * (first[b] * first[b] + first[c] * first[c]),
        12 * volume);
    p.inertia[a][b] = p.inertia[b][a] =
        round_quotient(first[a] * first[b] - volume * second[3 + a], 4 * volume);
  }
  return p;
}

}  // namespace boxunion

#include "core/solid/statistics.hpp"

#include <bit>
#include <cmath>
#include <utility>

#include "boxunion/octants.hpp"
#include "core/base/exact.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBoxGrain = 1 << 15;

/// Exact sums over boxes of 32-bit integers. Edges are below 2^32, so 2^32 boxes fit.
class IntegerSums {
 public:
  void add(const IntegerBox& box) {
    std::array<std::uint64_t, 3> edge;
    for (int a = 0; a < 3; ++a) edge[a] = std::uint64_t(std::int64_t{box[a + 3]} - box[a]);
    const UInt128 yz = UInt128(edge[1]) * edge[2];
    volume_ += edge[0] * yz;
    area_ += 2 * (yz + UInt128(edge[0]) * (edge[1] + edge[2]));
    length_ += 4 * (UInt128(edge[0]) + edge[1] + edge[2]);
  }
  Dyadic volume() const { return {BigInteger(volume_), 0}; }
  Dyadic area() const { return {BigInteger(area_), 0}; }
  Dyadic length() const { return {BigInteger(length_), 0}; }

 private:
  UInt128 volume_ = 0, area_ = 0, length_ = 0;
};

/// A finite double as +-magnitude * 2^(kLeastExponent + 8 * place), with magnitude < 2^60 (see PlacedSum).
struct Term {
  static constexpr int kLeastExponent = -1074, kGreatestExponent = 971;
  static constexpr std::size_t kGreatestPlace = (kGreatestExponent - kLeastExponent) / PlacedSum::kPlaceBits;

  std::uint64_t magnitude;
  bool negative;
  std::size_t place;

  explicit Term(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
    const int biased = int(bits >> 52 & 0x7ff);
    const auto offset = static_cast<std::size_t>(std::max(biased, 1) - 1);
    magnitude = (biased > 0 ? fraction | std::uint64_t{1} << 52 : fraction) << offset % PlacedSum::kPlaceBits;
    place = offset / PlacedSum::kPlaceBits;
    negative = bits >> 63;
  }
};

/// hi - lo, exactly, as the sum of at most two doubles (Knuth's TwoSum).
class Edge {
 public:
  Edge(double lo, double hi) {
    const double difference = hi - lo;
    if (!std::isfinite(difference)) {
      terms_[count_++] = Term(hi);
      terms_[count_++] = Term(-lo);
      return;
    }
    const double hi_part = difference + lo;
    const double rest = (hi - hi_part) - (lo - (hi_part - difference));
    terms_[count_++] = Term(difference);
    if (rest != 0) terms_[count_++] = Term(rest);
  }
  const Term* begin() const { return terms_.data(); }
  const Term* end() const { return terms_.data() + count_; }

 private:
  std::array<Term, 2> terms_{Term(0), Term(0)};
  std::size_t count_ = 0;
};

/// Exact sums over boxes of doubles.
class DoubleSums {
 public:
  void add(const Box& box) {
    const std::array<Edge, 3> edges{Edge(box[0], box[3]), Edge(box[1], box[4]), Edge(box[2], box[5])};
    for (int a = 0; a < 3; ++a)
      for (const Term& x : edges[a]) {
        length_.add(Words<1>{x.magnitude}, x.negative, x.place);
        for (const Term& y : edges[(a + 1) % 3]) {
          const Words<2> xy = Words<1>{x.magnitude} * y.magnitude;
          area_.add(xy, x.negative != y.negative, x.place + y.place);
          if (a > 0) continue;
          for (const Term& z : edges[2])
            volume_.add(xy * z.magnitude, (x.negative != y.negative) != z.negative,
                        x.place + y.place + z.place);
        }
      }
  }
  Dyadic volume() const { return volume_.total(); }
  Dyadic area() const { return 2 * area_.total(); }
  Dyadic length() const { return 4 * length_.total(); }

 private:
  PlacedSum volume_{3 * Term::kLeastExponent, 3 * Term::kGreatestPlace, 3};
  PlacedSum area_{2 * Term::kLeastExponent, 2 * Term::kGreatestPlace, 2};
  PlacedSum length_{Term::kLeastExponent, Term::kGreatestPlace, 1};
};

}  // namespace

struct BoxSummer::Share {
  IntegerSums integers;
  DoubleSums doubles;
  std::uint64_t vertices = 0;

  void add(const IntegerBox& box) { integers.add(box); }
  void add(const Box& box) { doubles.add(box); }
};

BoxSummer::BoxSummer() : shares_(std::make_unique<PerThread<Share>>()) {}
BoxSummer::~BoxSummer() = default;

void BoxSummer::add(const BoxSet& set) {
  set.visit([&]<class T>(const std::vector<BoxOf<T>>& boxes) {
    parallel_ranges(0, boxes.size(), kBoxGrain, [&](std::size_t begin, std::size_t end) {
      Share& mine = shares_->local();
      for (std::size_t i = begin; i < end; ++i) {
        const BoxOf<T>& b = boxes[i];
        if (b[0] == b[3] || b[1] == b[4] || b[2] == b[5]) continue;
        mine.add(b);
        mine.vertices += 8;
      }
    });
  });
}

BoxSums BoxSummer::sums() const {
  Dyadic volume, area, length;
  std::uint64_t vertices = 0;
  std::as_const(*shares_).for_each([&](const Share& share) {
    volume = volume + share.integers.volume() + share.doubles.volume();
    area = area + share.integers.area() + share.doubles.area();
    length = length + share.integers.length() + share.doubles.length();
    vertices += share.vertices;
  });
  return {round_to_double(volume), round_to_double(area), round_to_double(length), vertices};
}

BoxSums sum_boxes(const BoxSet& boxes) {
  BoxSummer summer;
  summer.add(boxes);
  return summer.sums();
}

void MaskCounter::add(std::span<const Vertex> vertices) {
  auto& counts = counts_.local();
  for (const Vertex& v : vertices) ++counts[v.mask];
  next_.add(vertices);
}

std::array<std::uint64_t, 256> MaskCounter::counts() const {
  std::array<std::uint64_t, 256> sum{};
  counts_.for_each([&](const auto& counts) {
    for (std::size_t mask = 0; mask < sum.size(); ++mask) sum[mask] += counts[mask];
  });
  return sum;
}

VertexKinds vertex_kinds(const std::array<std::uint64_t, 256>& counts) {
  VertexKinds kinds;
  for (unsigned mask = 0; mask < counts.size(); ++mask) {
    const int filled = std::popcount(mask);
    // of the masks with 5 filled octants, those that fill one side of an axis
    bool half = false;
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side) half |= detail::side_quadrants(mask, axis, side) == 15;
    (filled == 1                                    ? kinds.visible_input
     : filled == 7                                  ? kinds.three_face
     : filled == 5 && half && kOctants[mask].vertex ? kinds.edge_face
                                                    : kinds.other) += counts[mask];
  }
  return kinds;
}

}  // namespace boxunion

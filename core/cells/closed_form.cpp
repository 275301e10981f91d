#include "core/cells/closed_form.hpp"

#include <algorithm>
#include <array>

#include "boxunion/octants.hpp"

namespace boxunion {
namespace {

using Corner = std::array<std::uint32_t, 3>;

constexpr Corner unpack(std::uint64_t p) {
  return {packed::field(p, 0), packed::field(p, 1), packed::field(p, 2)};
}

// The relation of two intervals that touch: 3 * (order of the low ends) + order of the high ends, each 0 to
// 2; or one interval ends where the other begins.
constexpr unsigned kEndsAt = 9, kBeginsAt = 10, kRelations = 11;

constexpr unsigned relation(std::uint32_t a_lo, std::uint32_t a_hi, std::uint32_t b_lo, std::uint32_t b_hi) {
  if (a_hi == b_lo) return kEndsAt;
  if (b_hi == a_lo) return kBeginsAt;
  const auto order = [](std::uint32_t p, std::uint32_t q) { return unsigned(p > q) + unsigned(p >= q); };
  return 3 * order(a_lo, b_lo) + order(a_hi, b_hi);
}

/// Two intervals on 0 .. 3 for every relation. Bit i is set if the interval covers (i, i + 1).
struct Intervals {
  unsigned a, b;
};
constexpr Intervals example(unsigned relation) {
  if (relation == kEndsAt) return {1, 2};
  if (relation == kBeginsAt) return {2, 1};
  const auto interval = [](unsigned lo, unsigned hi) { return (1u << hi) - (1u << lo); };
  const unsigned low = relation / 3, high = relation % 3;
  return {interval(low == 2, high == 2 ? 3 : 2), interval(low == 0, high == 0 ? 3 : 2)};
}

/// The sides of point p (1 low, 2 high) that an interval fills, as bits.
constexpr unsigned sides(unsigned interval, unsigned p) {
  return (interval << 1 >> p) & 3;
}
/// The quadrants or octants that a box fills: `filled` on the previous axes, extended by the sides of one
/// more axis.
constexpr unsigned extend(unsigned filled, unsigned width, unsigned sides) {
  return (sides & 1) * filled | ((sides >> 1) * filled) << width;
}

struct PairTable {
  std::array<std::uint8_t, kRelations * kRelations> corners{};  // of two rectangles
  std::array<std::uint8_t, kRelations * kRelations * kRelations> vertices{}, extreme{};
};

PairTable make_pair_table() {
  PairTable table;
  for (unsigned z = 0; z < kRelations; ++z)
    for (unsigned y = 0; y < kRelations; ++y)
      for (unsigned q = 0; q < 16; ++q) {
        const unsigned a = extend(sides(example(y).a, q % 4), 2, sides(example(z).a, q / 4));
        const unsigned b = extend(sides(example(y).b, q % 4), 2, sides(example(z).b, q / 4));
        const unsigned yz = kRelations * z + y;
        table.corners[yz] = std::uint8_t(table.corners[yz] + detail::is_corner(a | b));
        for (unsigned x = 0; x < kRelations; ++x) {
          const Intervals interval = example(x);
          for (unsigned p = 0; p < 4; ++p) {
            const OctantProperties& point =
                kOctants[extend(a, 4, sides(interval.a, p)) | extend(b, 4, sides(interval.b, p))];
            std::uint8_t& vertices = table.vertices[kRelations * yz + x];
            std::uint8_t& extreme = table.extreme[kRelations * yz + x];
            vertices = std::uint8_t(vertices + point.vertex);
            extreme = std::uint8_t(extreme + point.extreme);
          }
        }
      }
  return table;
}

/// Made when first needed, because it is too much work for compilers.
const PairTable& pair_table() {
  static const PairTable table = make_pair_table();
  return table;
}

}  // namespace

void add_inside(LatticeSums& sums, const PackedRegion& region) {
  sums.add_box(unpack(region.lo - packed::kOnes), unpack(region.hi - packed::kOnes), {0, 0, 0});
}

void add_lone(LatticeSums& sums, const PackedBox& box, const PackedRegion& tile) {
  if (is_inside(box, tile))
    return sums.add_box(unpack(box.lo - packed::kOnes), unpack(box.hi - packed::kOnes), {2, 2, 2});
  std::uint64_t lo = box.lo;
  Corner ends;
  for (int a = 0; a < 3; ++a) {
    const bool begins = packed::field(lo, a) > 0;
    if (!begins) lo = packed::with_field(lo, a, 1);
    ends[a] = std::uint32_t(begins) + std::uint32_t(packed::field(box.hi, a) < packed::field(tile.hi, a));
  }
  sums.add_box(unpack(lo - packed::kOnes), unpack(box.hi - packed::kOnes), ends);
}

void add_pair(LatticeSums& sums, const PackedBox& a, const PackedBox& b) {
  const Corner a_lo = unpack(a.lo - packed::kOnes), a_hi = unpack(a.hi - packed::kOnes),
               b_lo = unpack(b.lo - packed::kOnes), b_hi = unpack(b.hi - packed::kOnes);
  Corner lo, hi, related;
  for (unsigned c = 0; c < 3; ++c) {
    lo[c] = std::max(a_lo[c], b_lo[c]);
    hi[c] = std::min(a_hi[c], b_hi[c]);
    related[c] = relation(a_lo[c], a_hi[c], b_lo[c], b_hi[c]);
  }
  sums.add_box(a_lo, a_hi, {2, 2, 2});
  sums.add_box(b_lo, b_hi, {2, 2, 2});
  sums.add_box(lo, hi, {2, 2, 2}, -1);
  const PairTable& table = pair_table();
  // so far 4 edges along the intersection, and 8 vertices, are subtracted
  for (unsigned c = 0; c < 3; ++c) {
    const std::int64_t corners = table.corners[kRelations * related[(c + 2) % 3] + related[(c + 1) % 3]];
    sums.length[c] += (corners - 4) * (std::int64_t{hi[c]} - lo[c]);
  }
  const unsigned at = kRelations * (kRelations * related[2] + related[1]) + related[0];
  sums.vertices += table.vertices[at] - std::uint64_t{8};
  sums.extreme += table.extreme[at] - std::uint64_t{8};
}

}  // namespace boxunion

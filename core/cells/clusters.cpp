#include "core/cells/clusters.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "core/base/instruction_set.hpp"
#include "core/base/sample.hpp"

namespace boxunion {
namespace {

constexpr std::uint32_t kGuards = 1u << 31 | 1u << 15;
using Lanes4 [[gnu::vector_size(16)]] = std::uint32_t;  // boxes compared at a time
using Lanes8 [[gnu::vector_size(32)]] = std::uint32_t;
constexpr std::uint32_t kMostLanes = 8;
constexpr std::uint64_t kMostCompared = 64;  // per box, on average
// Limits of division. A sweep would take at least so many comparisons per box, and a box touches at most so
// many others, by estimate and in fact.
constexpr std::uint64_t kLeastDivided = 512, kMostPairs = 8;
constexpr double kMostExpected = 2;
constexpr std::uint32_t kFirst = 512;   // of the first boxes, at most half of all, ...
constexpr double kMostTouching = 0.75;  // ... if more than this share touch a later one, the sweep gives up

/// y and z without their lowest `shift` bits, 15 bits each.
std::uint32_t pack_yz(std::uint64_t corner, int shift) {
  return (std::uint32_t(corner >> (packed::kBits + 1 + shift)) & 0x7fffu) |
         (std::uint32_t(corner >> (2 * packed::kBits + 2 - 16 + shift)) & 0x7fff0000u);
}

/// True if one of the boxes begin .. end - 1 touches the box on y and z, which are packed here. Compares as
/// many boxes at a time as Lanes has, so it reads some boxes beyond the end.
template <class Lanes>
[[gnu::always_inline]] inline bool any_touches(const std::uint32_t* los, const std::uint32_t* his,
                                               std::uint32_t begin, std::uint32_t end, std::uint32_t lo,
                                               std::uint32_t hi) {
  constexpr std::uint32_t lanes = sizeof(Lanes) / 4;
  Lanes found = {};
  for (std::uint32_t i = begin; i < end; i += lanes) {
    Lanes lo_lanes, hi_lanes;
    std::memcpy(&lo_lanes, los + i, sizeof lo_lanes);
    std::memcpy(&hi_lanes, his + i, sizeof hi_lanes);
    found |= ((hi_lanes - lo) & (hi - lo_lanes) & kGuards) == kGuards;
  }
  std::uint32_t any = 0;
  for (std::uint32_t i = 0; i < lanes; ++i) any |= found[i];
  return any != 0;
}

/// The average number of others that a box would touch if boxes with such edges were evenly distributed. By a
/// sample.
double expected_to_touch(std::span<const PackedBox> boxes) {
  constexpr std::size_t kSample = 24;
  std::vector<PackedBox> sample;
  Sample(boxes.size(), kSample).each([&](std::size_t i) { sample.push_back(boxes[i]); });
  std::array<double, 3> span;
  std::vector<std::array<double, 3>> edges(sample.size());
  for (unsigned a = 0; a < 3; ++a) {
    std::uint32_t lo = packed::kMax, hi = 0;
    for (std::size_t i = 0; i < sample.size(); ++i) {
      const std::uint32_t from = packed::field(sample[i].lo, int(a)),
                          to = packed::field(sample[i].hi, int(a));
      lo = std::min(lo, from), hi = std::max(hi, to);
      edges[i][a] = double(to - from);
    }
    span[a] = double(hi - lo);
  }
  double sum = 0;
  for (std::size_t i = 0; i < sample.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      double probability = 1;
      for (unsigned a = 0; a < 3; ++a)
        probability *= std::min(1.0, (edges[i][a] + edges[j][a] + 1) / span[a]);
      sum += probability;
    }
  return 2 * sum / double(sample.size() * (sample.size() - 1)) * double(boxes.size());
}

}  // namespace

bool Clusters::find(std::span<const PackedBox> boxes, std::uint32_t edge) {
  lone_.clear();
  members_.clear();
  ends_.clear();
  rest_.clear();
  sort(boxes, edge);
#ifdef __x86_64__
  const bool has_avx2 = instruction_set() == InstructionSet::x86_64_v3;
  if (!(has_avx2 ? join_touching_with_avx2(boxes) : join_touching<Lanes4>(boxes))) return false;
#else
  if (!join_touching<Lanes4>(boxes)) return false;
#endif
  gather();
  return true;
}

/// Sorts by low x, by counting. Shifted coordinates may make boxes seem to touch that do not, but never the
/// reverse.
void Clusters::sort(std::span<const PackedBox> boxes, std::uint32_t edge) {
  const int log_edge = std::bit_width(edge);
  const int log_buckets = std::min(13, 1 + int(std::bit_width(boxes.size())));  // a few buckets for every box
  const int x_shift = std::max(0, log_edge - log_buckets), yz_shift = std::max(0, log_edge - 14);
  const auto bucket = [&](std::uint64_t corner) { return packed::field(corner, 0) >> x_shift; };
  bucket_end_.assign(((edge + 1) >> x_shift) + 2, 0);
  for (const PackedBox& box : boxes) ++bucket_end_[bucket(box.lo) + 1];
  std::uint32_t sum = 0;
  for (std::uint32_t& end : bucket_end_) end = sum += end;
  const std::size_t n = boxes.size();
  index_.resize(n);
  last_.resize(n);
  lo_.resize(n + kMostLanes);
  hi_.resize(n + kMostLanes);
  std::fill_n(lo_.begin() + std::ptrdiff_t(n), kMostLanes,
              ~kGuards);  // padding behind the last box touches nothing
  std::fill_n(hi_.begin() + std::ptrdiff_t(n), kMostLanes, kGuards);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t place = bucket_end_[bucket(boxes[i].lo)]++;
    index_[place] = i;
    last_[place] = bucket(boxes[i].hi);
    lo_[place] = pack_yz(boxes[i].lo, yz_shift);
    hi_[place] = pack_yz(boxes[i].hi, yz_shift) | kGuards;
  }
}

/// Joins the trees of boxes that touch. False if that takes, or would take, too many comparisons.
template <class Lanes>
[[gnu::always_inline]] inline bool Clusters::join_touching(std::span<const PackedBox> boxes) {
  constexpr std::uint32_t lanes = sizeof(Lanes) / 4;
  const auto n = std::uint32_t(boxes.size());
  std::uint64_t compared = 0;
  for (std::uint32_t i = 0; i < n; ++i) compared += bucket_end_[last_[i]] - i;
  parent_.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) parent_[i] = i;
  if (compared > kLeastDivided * n) return join_by_division(boxes);
  if (compared > kMostCompared * n) return false;
  const std::uint32_t first = std::min(kFirst, n / 2), most_touching = std::uint32_t(kMostTouching * first);
  std::uint32_t touching = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t end = bucket_end_[last_[i]];
    const auto any_of = [&](std::uint32_t first, std::uint32_t last) {
      return any_touches<Lanes>(lo_.data(), hi_.data(), first, last, lo_[i], hi_[i]);
    };
    if (!any_of(i + 1, end)) continue;
    if (++touching > most_touching && i < first) return false;
    const PackedBox& box = boxes[index_[i]];
    for (std::uint32_t j = i + 1; j < end; j += lanes) {
      if (!any_of(j, j + 1)) continue;
      for (std::uint32_t k = j; k < std::min(j + lanes, end); ++k)
        if (packed::all_le(box.lo, boxes[index_[k]].hi) && packed::all_le(boxes[index_[k]].lo, box.hi))
          join(i, k);
    }
  }
  return true;
}

#ifdef __x86_64__
[[gnu::target("avx2")]] bool Clusters::join_touching_with_avx2(std::span<const PackedBox> boxes) {
  return join_touching<Lanes8>(boxes);
}
#endif

/// The same for boxes that are too long for a sweep. False if many of them touch.
bool Clusters::join_by_division(std::span<const PackedBox> boxes) {
  if (expected_to_touch(boxes) > kMostExpected) return false;
  std::vector<std::uint32_t> place(boxes.size());
  for (std::uint32_t i = 0; i < place.size(); ++i) place[index_[i]] = i;
  return pairs_.find(boxes, kMostPairs * boxes.size(),
                     [&](std::uint32_t i, std::uint32_t j) { join(place[i], place[j]); });
}

void Clusters::join(std::uint32_t i, std::uint32_t j) {
  const std::uint32_t x = root(i), y = root(j);
  parent_[std::max(x, y)] = std::min(x, y);
}

std::uint32_t Clusters::root(std::uint32_t i) {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

void Clusters::gather() {
  const auto n = std::uint32_t(index_.size());
  size_.assign(n, 0);
  next_.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) ++size_[parent_[i] = root(i)];
  lone_.resize(n);
  members_.resize(n);
  std::uint32_t lone = 0, members = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t r = parent_[i];
    if (size_[r] == 1) {
      lone_[lone++] = index_[i];
    } else if (size_[r] > kMostBoxes) {
      rest_.push_back(index_[i]);
    } else {
      if (r == i) {
        next_[r] = members;
        members += size_[r];
        ends_.push_back(members);
      }
      members_[next_[r]++] = index_[i];
    }
  }
  lone_.resize(lone);
  members_.resize(members);
}

}  // namespace boxunion

#include "core/clusters.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace boxunion {
namespace {

constexpr std::uint32_t kGuards = 1u << 31 | 1u << 15;
constexpr std::uint32_t kLanes = 4;  // boxes compared at a time
using Lanes [[gnu::vector_size(16)]] = std::uint32_t;
constexpr std::uint64_t kMostCompared = 64;   // per box, on average
constexpr std::uint32_t kFirst = 512;         // if of the first ones ...
constexpr std::uint32_t kMostTouching = 384;  // ... more than these touch a later one, the sweep gives up

/// y and z less their lowest `shift` bits, 15 bits each.
std::uint32_t pack_yz(std::uint64_t corner, int shift) {
  return (std::uint32_t(corner >> (packed::kBits + 1 + shift)) & 0x7fffu) |
         (std::uint32_t(corner >> (2 * packed::kBits + 2 - 16 + shift)) & 0x7fff0000u);
}

Lanes lanes_at(const std::vector<std::uint32_t>& values, std::size_t i) {
  Lanes lanes;
  std::memcpy(&lanes, values.data() + i, sizeof lanes);
  return lanes;
}

bool any(const Lanes& lanes) {
  return (lanes[0] | lanes[1] | lanes[2] | lanes[3]) != 0;
}

}  // namespace

bool Clusters::find(std::span<const PackedBox> boxes, std::uint32_t edge) {
  lone_.clear();
  members_.clear();
  ends_.clear();
  rest_.clear();
  sort(boxes, edge);
  if (!join_touching(boxes)) return false;
  gather();
  return true;
}

/// A counting sort by low x. Shifted coordinates may make boxes seem to touch that do not, never the reverse.
void Clusters::sort(std::span<const PackedBox> boxes, std::uint32_t edge) {
  const int log_edge = std::bit_width(edge);
  const int log_buckets = std::min(13, 1 + int(std::bit_width(boxes.size())));  // a few for every box
  const int x_shift = std::max(0, log_edge - log_buckets), yz_shift = std::max(0, log_edge - 14);
  const auto bucket = [&](std::uint64_t corner) { return packed::field(corner, 0) >> x_shift; };
  bucket_end_.assign(((edge + 1) >> x_shift) + 2, 0);
  for (const PackedBox& box : boxes) ++bucket_end_[bucket(box.lo) + 1];
  std::uint32_t sum = 0;
  for (std::uint32_t& end : bucket_end_) end = sum += end;
  const std::size_t n = boxes.size();
  index_.resize(n);
  last_.resize(n);
  lo_.resize(n + kLanes);
  hi_.resize(n + kLanes);
  std::fill_n(lo_.begin() + std::ptrdiff_t(n), kLanes,
              ~kGuards);  // what is behind the last box touches nothing
  std::fill_n(hi_.begin() + std::ptrdiff_t(n), kLanes, kGuards);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t place = bucket_end_[bucket(boxes[i].lo)]++;
    index_[place] = i;
    last_[place] = bucket(boxes[i].hi);
    lo_[place] = pack_yz(boxes[i].lo, yz_shift);
    hi_[place] = pack_yz(boxes[i].hi, yz_shift) | kGuards;
  }
}

/// Joins the trees of boxes that touch. False if that would take or takes too many comparisons.
bool Clusters::join_touching(std::span<const PackedBox> boxes) {
  const auto n = std::uint32_t(boxes.size());
  std::uint64_t compared = 0;
  for (std::uint32_t i = 0; i < n; ++i) compared += bucket_end_[last_[i]] - i;
  if (compared > kMostCompared * n) return false;
  parent_.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) parent_[i] = i;
  std::uint32_t touching = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t lo = lo_[i], hi = hi_[i], end = bucket_end_[last_[i]];
    const auto touching_lanes = [&](std::uint32_t j) -> Lanes {
      return ((lanes_at(hi_, j) - lo) & (hi - lanes_at(lo_, j)) & kGuards) == kGuards;
    };
    Lanes found = {};
    for (std::uint32_t j = i + 1; j < end; j += kLanes) found |= touching_lanes(j);
    if (!any(found)) continue;
    if (++touching > kMostTouching && i < kFirst) return false;
    const PackedBox& box = boxes[index_[i]];
    for (std::uint32_t j = i + 1; j < end; j += kLanes) {
      if (!any(touching_lanes(j))) continue;
      for (std::uint32_t k = j; k < std::min(j + kLanes, end); ++k)
        if (packed::all_le(box.lo, boxes[index_[k]].hi) && packed::all_le(boxes[index_[k]].lo, box.hi)) {
          const std::uint32_t x = root(i), y = root(k);
          parent_[std::max(x, y)] = std::min(x, y);
        }
    }
  }
  return true;
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

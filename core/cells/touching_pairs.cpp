#include "core/cells/touching_pairs.hpp"

#include <algorithm>
#include <numeric>

#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kFew = 24;  // so few boxes are compared with all others

}  // namespace

bool TouchingPairs::find(std::span<const PackedBox> boxes, std::size_t most, const Take& take) {
  boxes_ = boxes;
  take_ = &take;
  left_ = most;
  Indices all(boxes.size());
  std::iota(all.begin(), all.end(), 0u);
  divide(all, all, kWhole, 2);
  return left_ > 0;
}

/// Compares each box of `spans` with the boxes of `points` whose low end lies in the part and within the box
/// on an axis.
void TouchingPairs::divide(Items spans, Items points, Part part, int axis) {
  if (spans.empty() || points.empty() || left_ == 0) return;
  if (std::min(spans.size(), points.size()) <= kFew) return compare_all(spans, points);
  if (axis == 0) return scan(spans, points);
  Interruptible::check();

  const auto covers = [&](std::uint32_t i) {
    return low(i, axis) <= part.lo && part.hi <= high(i, axis) + 1;
  };
  Indices covering, rest;
  for (const std::uint32_t i : spans) (covers(i) ? covering : rest).push_back(i);
  divide_on_next_axis(covering, points, axis);
  covering = {};
  if (rest.empty()) return;

  Indices lows;
  Sample(points.size(), 64).each([&](std::size_t i) { lows.push_back(low(points[i], axis)); });
  std::ranges::nth_element(lows, lows.begin() + std::ptrdiff_t(lows.size() / 2));
  const std::uint32_t middle = std::max(lows[lows.size() / 2], part.lo + 1);
  for (const Part half : {Part{part.lo, middle}, Part{middle, part.hi}}) {
    const auto is_within = [&](std::uint32_t i) { return half.lo <= low(i, axis) && low(i, axis) < half.hi; };
    const auto reaches = [&](std::uint32_t i) { return low(i, axis) < half.hi && half.lo <= high(i, axis); };
    Indices here, reaching;
    std::ranges::copy_if(points, std::back_inserter(here), is_within);
    std::ranges::copy_if(rest, std::back_inserter(reaching), reaches);
    divide(reaching, here, half, axis);
  }
}

/// Divides on the next axis. There, the low end of either box may lie within the other.
void TouchingPairs::divide_on_next_axis(Items spans, Items points, int axis) {
  divide(spans, points, kWhole, axis - 1);
  divide(points, spans, kWhole, axis - 1);
}

/// The last axis. By now, nearly all boxes whose low ends lie within another box touch it.
void TouchingPairs::scan(Items spans, Items points) {
  std::vector<std::array<std::uint32_t, 2>> lows;  // low ends and their boxes
  for (const std::uint32_t i : points) lows.push_back({low(i, 0), i});
  std::ranges::sort(lows);
  for (const std::uint32_t i : spans) {
    if (left_ == 0) return;
    const std::array first{low(i, 0), 0u};
    for (auto at = std::ranges::lower_bound(lows, first); at != lows.end() && (*at)[0] <= high(i, 0); ++at)
      compare(i, (*at)[1]);
  }
}

void TouchingPairs::compare_all(Items spans, Items points) {
  for (const std::uint32_t i : spans)
    for (const std::uint32_t j : points) compare(i, j);
}

void TouchingPairs::compare(std::uint32_t i, std::uint32_t j) {
  if (i == j || left_ == 0) return;
  if (!packed::all_le(boxes_[i].lo, boxes_[j].hi) || !packed::all_le(boxes_[j].lo, boxes_[i].hi)) return;
  --left_;
  (*take_)(i, j);
}

}  // namespace boxunion

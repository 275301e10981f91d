// The part of TileCutter for boolean expressions: simplifies them region by region, keeps the boxes of their
// operands separate, and writes the programs of cells.

#include <algorithm>

#include "core/cells/cells.hpp"
#include "core/cells/closed_form.hpp"

namespace boxunion {

/// Finds the clusters of an expression that is false wherever there are no boxes.
void TileCutter::cut_clusters(const PackedRegion& tile, Steps steps) {
  batch_->boxes.insert(batch_->boxes.end(), boxes_.begin(), boxes_.end());
  const auto add_cluster = [&](Items cluster) {
    const PackedRegion region = bounding_region(tile, cluster);
    Steps left = steps;
    const Filling filling = reduce(region, cluster, left, cluster_);
    if (filling == Filling::nothing) return;
    if (filling == Filling::everything) return add_covered(region);
    const PackedBox &first = boxes_[cluster.front()], &last = boxes_[cluster.back()];
    const bool lone = cluster.size() == 1;
    const bool pair = cluster.size() == 2 && is_inside(first, tile) && is_inside(last, tile) &&
                      packed::all_le(first.lo, last.hi) && packed::all_le(last.lo, first.hi);
    if (!sums_ || !left.empty() || !(lone || pair)) return add_cell(region, cluster, left);
    if (lone)
      add_lone(*sums_, first, tile);
    else
      add_pair(*sums_, first, last);
    for (const std::uint32_t i : cluster) reach_.extend(boxes_[i], tile);
    ++statistics_.cells;
    statistics_.items += cluster.size();
  };
  for (const std::uint32_t& i : clusters_.lone()) add_cluster({&i, 1});
  std::vector<std::uint32_t> members;  // sorted by operand, like the boxes
  const auto sorted = [&](Items items) {
    members.assign(items.begin(), items.end());
    std::ranges::sort(members);
    return Items(members);
  };
  std::size_t begin = 0;
  for (const std::uint32_t end : clusters_.ends()) {
    add_cluster(sorted(clusters_.members().subspan(begin, end - begin)));
    begin = end;
  }
  if (!clusters_.rest().empty()) cut_region(tile, sorted(clusters_.rest()), steps, 0);
}

bool TileCutter::is_empty_without_boxes(Steps steps) {
  if (steps.empty()) return true;
  std::ranges::fill(presence_, Presence::absent);
  return simplify(steps, presence_, cluster_.steps) == Filling::nothing;
}

/// Simplifies an expression in a region. If it varies there, steps and items become the remaining ones, in
/// memory of `level`.
Filling TileCutter::reduce(const PackedRegion& region, Items& items, Steps& steps, Level& level) {
  std::ranges::fill(presence_, Presence::absent);
  for (const std::uint32_t i : items)
    if (Presence& presence = presence_[operands_[i]]; presence != Presence::all)
      presence = region.covered_by(boxes_[i]) ? Presence::all : Presence::partial;
  const Filling filling = simplify(steps, presence_, level.steps);
  if (filling != Filling::varies) return filling;
  steps = is_union(level.steps) ? Steps() : Steps(level.steps);
  std::ranges::fill(presence_, Presence::absent);
  for (const Step step : level.steps)
    if (step.kind == Step::Kind::operand) presence_[step.operand] = Presence::partial;
  level.relevant.clear();
  for (const std::uint32_t i : items)
    if (presence_[operands_[i]] != Presence::absent) level.relevant.push_back(i);
  items = level.relevant;
  return filling;
}

/// Calls f(items) for the items of each operand.
template <class F>
void TileCutter::each_operand(Items items, F&& f) const {
  for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
    const std::uint32_t operand = operands_[items[begin]];
    do ++end;
    while (end < items.size() && operands_[items[end]] == operand);
    f(items.subspan(begin, end - begin));
  }
}

/// Drops hidden boxes. Only boxes of the same operand hide each other.
TileCutter::Items TileCutter::drop_hidden_by_operand(const PackedRegion& region, Items items,
                                                     Level& level) const {
  level.visible.clear();
  each_operand(items, [&](Items of_one) {
    const Items kept = drop_hidden(region, of_one, level.kept);
    level.visible.insert(level.visible.end(), kept.begin(), kept.end());
  });
  return level.visible;
}

/// Continues with half of a region, whose boxes are stack_[begin ..].
void TileCutter::halve_expression(const PackedRegion& half, std::size_t begin, Steps steps,
                                  std::size_t depth) {
  if (halvings_.size() == depth) halvings_.emplace_back();
  Items items = Items(stack_).subspan(begin);
  const Filling filling = reduce(half, items, steps, halvings_[depth]);
  stack_.resize(begin);
  if (filling == Filling::everything) add_covered(half);
  if (filling != Filling::varies) return;
  stack_.insert(stack_.end(), items.begin(), items.end());
  halve(half, begin, steps, depth + 1);
}

/// Removes equal clips from stack_[begin ..]. For an expression, clips are equal only within an operand.
void TileCutter::merge(const PackedRegion& region, std::size_t begin, Steps steps) {
  const std::span<std::uint32_t> items = std::span(stack_).subspan(begin);
  std::size_t count = 0;
  const auto merge_some = [&](std::size_t first, std::size_t size) {
    const std::size_t kept = merge_equal_clips(region, items.subspan(first, size));
    std::ranges::copy(items.subspan(first, kept), items.begin() + std::ptrdiff_t(count));
    count += kept;
  };
  if (steps.empty())
    merge_some(0, items.size());
  else
    each_operand(items,
                 [&](Items some) { merge_some(std::size_t(some.data() - items.data()), some.size()); });
  stack_.resize(begin + count);
}

/// Appends the last cell's program. If it has steps, the kernel finds the reach of the cell.
void TileCutter::add_program(const PackedRegion& region, Items items, Steps steps) {
  if (steps.empty()) {
    batch_->programs.emplace_back();
    for (const std::uint32_t i : items) reach_.extend(boxes_[i], region);
    return;
  }
  each_operand(items, [&](Items of_one) {
    cell_boxes_[operands_[of_one.front()]] = {std::uint32_t(of_one.data() - items.data()),
                                              std::uint32_t(of_one.size())};
  });
  batch_->programs.push_back(append_program(steps, cell_boxes_, batch_->steps));
}

}  // namespace boxunion

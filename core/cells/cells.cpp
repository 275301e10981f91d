#include "core/cells/cells.hpp"

#include <bit>
#include <cmath>
#include <numeric>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"
#include "core/base/sample.hpp"
#include "core/cells/closed_form.hpp"
#include "core/cells/halving.hpp"
#include "kernels/contract.h"

namespace boxunion {
namespace {

constexpr std::uint32_t kRanks = CELL_RANKS;
constexpr std::uint32_t kDefaultCellBoxes = 20;  // a cell with more boxes is cut again
constexpr double kGoalBoxes = 7;                 // average in a cell of a grid
constexpr std::size_t kMostCells = 1u << 18;     // of a grid
constexpr std::size_t kGridBoxes = 60;  // a crowded cell with more boxes gets a grid, with fewer it is halved
constexpr double kMostMisjudged = 8;    // factor of the estimate of touched cells
constexpr std::size_t kMostDepth = 8;   // nesting of grids
constexpr std::uint64_t kStepCost = 32;  // cost of a step of a program; a pair of boxes costs 1

using packed::field;

/// Sorts numbers in [lo, hi) and removes duplicates.
void make_distinct(std::vector<std::uint32_t>& numbers, std::uint32_t lo, std::uint32_t hi) {
  constexpr std::uint32_t kBitmap = 512;
  if (hi - lo > kBitmap) {
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return;
  }
  std::array<std::uint64_t, kBitmap / 64> bits{};
  for (const std::uint32_t number : numbers)
    bits[(number - lo) / 64] |= std::uint64_t{1} << (number - lo) % 64;
  numbers.clear();
  for (std::uint32_t w = 0; w < bits.size(); ++w)
    for (std::uint64_t word = bits[w]; word; word &= word - 1)
      numbers.push_back(lo + 64 * w + std::uint32_t(std::countr_zero(word)));
}

}  // namespace

void CellBatch::clear() {
  boxes.clear();
  items.clear();
  cells.clear();
  runs.clear();
  tiles.clear();
  programs.clear();
  steps.clear();
}

void CellBatch::append(const CellBatch& other) {
  const auto shift_box = std::uint32_t(boxes.size()), shift_item = std::uint32_t(items.size()),
             shift_cell = std::uint32_t(cells.size()), shift_step = std::uint32_t(steps.size());
  const std::size_t shift_run = runs.size();
  boxes.insert(boxes.end(), other.boxes.begin(), other.boxes.end());
  for (const std::uint32_t i : other.items) items.push_back(i + shift_box);
  for (Cell c : other.cells) {
    c.first += shift_item;
    cells.push_back(c);
  }
  for (CellRun r : other.runs) {
    r.first += shift_cell;
    runs.push_back(r);
  }
  for (TileRuns t : other.tiles) {
    t.end_run += shift_run;
    tiles.push_back(t);
  }
  for (CellProgram p : other.programs) {
    p.first += shift_step;
    programs.push_back(p);
  }
  steps.insert(steps.end(), other.steps.begin(), other.steps.end());
}

void Reach::extend(const PackedBox& box, const PackedRegion& region) {
  for (int a = 0; a < 3; ++a) {
    lo[a] = std::min(lo[a], std::max(field(box.lo, a), field(region.lo, a)));
    hi[a] = std::max(hi[a], std::min(field(box.hi, a), field(region.hi, a)));
  }
}

CellStatistics& CellStatistics::operator+=(const CellStatistics& other) {
  cells += other.cells;
  covered_cells += other.covered_cells;
  items += other.items;
  return *this;
}

PackedRegion TileCutter::Grid::cell(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
  const std::array<std::uint32_t, 3> at{x, y, z};
  std::array<std::uint32_t, 3> lo, hi;
  for (int a = 0; a < 3; ++a) {
    const std::uint32_t base = field(region.lo, a);
    lo[a] = base + (at[a] << log_edge[a]);
    hi[a] = std::min(lo[a] + (1u << log_edge[a]), field(region.hi, a));
  }
  return {packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])};
}

TileCutter::TileCutter(Tuning tuning, std::size_t operands)
    : tuning_(tuning), levels_(kMostDepth + 1), presence_(operands), cell_boxes_(operands) {
  if (!tuning_.cell_boxes) tuning_.cell_boxes = kDefaultCellBoxes;
}

void TileCutter::cut(const TileBoxes& content, std::span<const Step> steps,
                     const std::array<std::uint32_t, 3>& edge, const std::array<std::uint32_t, 3>& origin,
                     std::uint64_t run_cost, CellBatch& batch, LatticeSums* sums) {
  const std::span<const PackedBox> boxes = content.boxes;
  boxes_ = boxes;
  operands_ = content.operands;
  reach_ = {};
  batch_ = &batch;
  sums_ = sums;
  first_box_ = std::uint32_t(batch.boxes.size());
  const std::size_t first_cell = batch.cells.size();
  const PackedRegion tile{packed::kOnes, packed::pack(edge[0] + 1, edge[1] + 1, edge[2] + 1)};
  tile_end_ = tile.hi;
  const bool clusters = !tuning_.cell && is_empty_without_boxes(steps);
  if (clusters && clusters_.find(boxes, std::ranges::max(edge))) {
    if (steps.empty())
      cut_clusters(tile);
    else
      cut_clusters(tile, steps);
  } else {
    batch.boxes.insert(batch.boxes.end(), boxes.begin(), boxes.end());
    cut_region(tile, first_indices(boxes.size()), steps, 0);
  }
  add_runs(first_cell, origin, run_cost);
}

/// Sorts the cells from `first` on by their numbers of boxes, as far as these are usual. Neighboring runs
/// then take similar times, because devices may run them in lockstep.
void TileCutter::sort_by_count(std::size_t first) {
  const std::span<Cell> cells = std::span(batch_->cells).subspan(first);
  std::array<std::size_t, kRanks + 1> place{};
  const auto bucket = [](const Cell& cell) { return std::min(cell.count, kRanks - 1); };
  for (const Cell& cell : cells) ++place[bucket(cell) + 1];
  std::inclusive_scan(place.begin(), place.end(), place.begin());
  unsorted_.assign(cells.begin(), cells.end());
  for (const Cell& cell : unsorted_) cells[place[bucket(cell)]++] = cell;
}

/// Groups the cells of the tile from `first` on into runs.
void TileCutter::add_runs(std::size_t first, const std::array<std::uint32_t, 3>& origin,
                          std::uint64_t run_cost) {
  CellBatch& batch = *batch_;
  const auto cost_of = [&](std::size_t c) {
    const std::uint64_t count = batch.cells[c].count;
    return count * count + 4 + (batch.programs.empty() ? 0 : kStepCost * batch.programs[c].count);
  };
  std::uint64_t all = 0;
  for (std::size_t c = first; c < batch.cells.size(); ++c) all += cost_of(c);
  if (all > run_cost && batch.programs.empty()) sort_by_count(first);
  for (std::size_t c = first; c < batch.cells.size();) {
    CellRun run{std::uint32_t(c), 0, origin};
    std::uint64_t cost = 0;
    do {
      cost += cost_of(c++);
      ++run.count;
    } while (c < batch.cells.size() && cost < run_cost);
    batch.runs.push_back(run);
  }
}

void TileCutter::add_covered_tile(const std::array<std::uint32_t, 3>& edge, LatticeSums* sums) {
  sums_ = sums;
  reach_ = {};
  tile_end_ = packed::pack(edge[0] + 1, edge[1] + 1, edge[2] + 1);
  add_covered({packed::kOnes, tile_end_});
}

/// 0 .. count - 1
TileCutter::Items TileCutter::first_indices(std::size_t count) {
  while (all_.size() < count) all_.push_back(std::uint32_t(all_.size()));
  return Items(all_).first(count);
}

/// Gives every small cluster a cell, or adds it to the sums if it has a closed form. A grid cuts the rest.
void TileCutter::cut_clusters(const PackedRegion& tile) {
  const auto keep = [&](Items items) {
    for (const std::uint32_t i : items) batch_->boxes.push_back(boxes_[i]);
    const std::size_t kept = batch_->boxes.size() - first_box_;
    return first_indices(kept).last(items.size());
  };
  const auto add_cluster = [&](Items cluster) {
    const PackedRegion region = bounding_region(tile, cluster);
    add_cell(region, keep(cluster));
  };
  const auto add_sums = [&](std::size_t boxes) {
    ++statistics_.cells;
    statistics_.items += boxes;
  };
  LatticeSums sums = sums_ ? *sums_ : LatticeSums{};  // a local copy, which may stay in registers
  if (has_operands())
    for (const PackedBox& box : boxes_) reach_.extend(box, tile);
  for (const std::uint32_t& i : clusters_.lone()) {
    if (sums_)
      add_lone(sums, boxes_[i], tile), add_sums(1);
    else
      add_cluster({&i, 1});
  }
  std::size_t begin = 0;
  for (const std::uint32_t end : clusters_.ends()) {
    const Items cluster = clusters_.members().subspan(begin, end - begin);
    begin = end;
    if (sums_ && cluster.size() == 2 && is_inside(boxes_[cluster[0]], tile) &&
        is_inside(boxes_[cluster[1]], tile))
      add_pair(sums, boxes_[cluster[0]], boxes_[cluster[1]]), add_sums(2);
    else
      add_cluster(cluster);
  }
  if (sums_) *sums_ = sums;
  if (clusters_.rest().empty()) return;
  const Items rest = keep(clusters_.rest());
  boxes_ = std::span(batch_->boxes).subspan(first_box_);
  cut_region(tile, rest, {}, 0);
}

/// The smallest region that owns all points of the boxes that the tile owns.
PackedRegion TileCutter::bounding_region(const PackedRegion& tile, Items items) const {
  std::array<std::uint32_t, 3> lo, hi;
  for (int a = 0; a < 3; ++a) {
    lo[a] = packed::kMax, hi[a] = 0;
    for (const std::uint32_t i : items) {
      lo[a] = std::min(lo[a], field(boxes_[i].lo, a));
      hi[a] = std::max(hi[a], field(boxes_[i].hi, a));
    }
    lo[a] = std::max(lo[a], field(tile.lo, a));
    hi[a] = std::min(hi[a] + 1, field(tile.hi, a));
  }
  return {packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])};
}

/// True if a region can own a vertex: on each axis, it owns an end of a box or, if sums end with the tile, it
/// ends with the tile.
bool TileCutter::may_have_vertices(const PackedRegion& region, Items items) const {
  std::uint64_t axes = 0;  // guard bits
  if (sums_)
    for (int a = 0; a < 3; ++a)
      if (field(region.hi, a) == field(tile_end_, a)) axes |= packed::guard(a);
  const auto owned = [&](std::uint64_t corner) {
    return ((corner | packed::kGuards) - region.lo) &
           (((region.hi - packed::kOnes) | packed::kGuards) - corner);
  };
  for (std::size_t i = 0; i < items.size() && axes != packed::kGuards; ++i)
    axes |= (owned(boxes_[items[i]].lo) | owned(boxes_[items[i]].hi)) & packed::kGuards;
  return axes == packed::kGuards;
}

/// Cuts a region with any boxes into cells.
void TileCutter::cut_region(const PackedRegion& region, Items items, Steps steps, std::size_t depth) {
  Interruptible::check();
  if (!steps.empty()) {
    const Filling filling = reduce(region, items, steps, levels_[depth]);
    if (filling == Filling::nothing) return;
    if (filling == Filling::everything) return add_covered(region);
  }
  if (!may_have_vertices(region, items)) return;
  const bool fixed_grid = tuning_.cell && depth == 0;
  const std::size_t surely_fits = std::min(tuning_.cell_boxes, kRanks / 2);
  if (items.size() <= surely_fits && !fixed_grid) return add_cell(region, items, steps);
  items = steps.empty() ? drop_hidden(region, items, levels_[depth].kept)
                        : drop_hidden_by_operand(region, items, levels_[depth]);
  if (items.size() <= surely_fits && !fixed_grid) return add_cell(region, items, steps);
  if ((items.size() > kGridBoxes || fixed_grid) && depth < kMostDepth) {
    const Grid grid = choose_grid(region, items, fixed_grid);
    if (grid.count() > 1 && cut_by_grid(grid, items, steps, depth)) return;
  }
  stack_.assign(items.begin(), items.end());
  halve(region, 0, steps, 0);
}

/// Drops boxes that lie inside another one, within the region, so that few of nested, concentric or equal
/// boxes are left before a grid multiplies them. As long as the largest box of a sample hides a quarter of
/// the sample, it is compared with all boxes. A region without such boxes therefore costs only the sample,
/// and other regions a linear number of tests. May return memory of `kept`.
TileCutter::Items TileCutter::drop_hidden(const PackedRegion& region, Items items,
                                          std::vector<std::uint32_t>& kept) const {
  constexpr std::size_t kSample = 32;
  while (items.size() > 2 * kSample) {
    const Sample sample(items.size(), kSample);
    std::uint32_t largest = items[0];
    double most = -1;
    sample.each([&](std::size_t i) {
      double volume = 1;
      for (int a = 0; a < 3; ++a)
        volume *= double(std::min(field(boxes_[items[i]].hi, a), field(region.hi, a))) -
                  double(std::max(field(boxes_[items[i]].lo, a), field(region.lo, a) - 1));
      if (volume > most) largest = items[i], most = volume;
    });
    // ignore everything outside the region
    PackedBox outer = boxes_[largest];
    for (int a = 0; a < 3; ++a) {
      if (field(outer.lo, a) < field(region.lo, a)) outer.lo = packed::with_field(outer.lo, a, 0);
      if (field(outer.hi, a) >= field(region.hi, a)) outer.hi = packed::with_field(outer.hi, a, packed::kMax);
    }
    const auto hidden = [&](std::uint32_t i) {
      return packed::all_le(outer.lo, boxes_[i].lo) && packed::all_le(boxes_[i].hi, outer.hi) && i != largest;
    };
    std::size_t looked_at = 0, hidden_sample = 0;
    sample.each([&](std::size_t i) { ++looked_at, hidden_sample += hidden(items[i]); });
    if (4 * hidden_sample < looked_at) break;
    kept.resize(std::max(kept.size(), items.size()));  // the items may be stored here
    std::size_t count = 0;
    for (std::size_t i = 0; i < items.size(); ++i)
      if (const std::uint32_t item = items[i]; !hidden(item)) kept[count++] = item;
    items = Items(kept).first(count);
  }
  return items;
}

/// A grid whose cells hold a handful of boxes by the estimate from a sample, or whose cells have the
/// requested size.
TileCutter::Grid TileCutter::choose_grid(const PackedRegion& region, Items items, bool fixed) const {
  Grid grid{region, {}, {}};
  std::array<std::uint32_t, 3> edge;
  for (int a = 0; a < 3; ++a) {
    edge[a] = field(region.hi, a) - field(region.lo, a);
    grid.log_edge[a] = std::bit_width(edge[a] - 1);
  }
  const auto count_cells = [&] {
    for (int a = 0; a < 3; ++a) grid.cells[a] = ((edge[a] - 1) >> grid.log_edge[a]) + 1;
  };
  if (fixed) {
    for (int& log : grid.log_edge) log = std::min(log, int(std::bit_width(tuning_.cell - 1)));
    count_cells();
    for (; grid.count() > kMostCells; count_cells()) ++*std::ranges::min_element(grid.log_edge);
    grid.most_items = kMostCells + 64 * items.size();
    return grid;
  }

  constexpr std::size_t kSample = 128;
  std::array<std::array<float, kSample>, 3> extent;
  std::size_t sample = 0;
  Sample(items.size(), kSample).each([&](std::size_t i) {
    for (int a = 0; a < 3; ++a)
      extent[a][sample] = float(std::min(field(boxes_[items[i]].hi, a), field(region.hi, a)) -
                                std::max(field(boxes_[items[i]].lo, a), field(region.lo, a) - 1));
    ++sample;
  });
  const auto items_per_box = [&](const std::array<int, 3>& log_edge) {
    std::array<float, 3> scale;
    for (int a = 0; a < 3; ++a) scale[a] = 1 / float(1u << log_edge[a]);
    float sum = 0;
    for (std::size_t i = 0; i < sample; ++i)
      sum += (1 + extent[0][i] * scale[0]) * (1 + extent[1][i] * scale[1]) * (1 + extent[2][i] * scale[2]);
    return double(sum) / double(sample);
  };
  count_cells();
  double per_box = items_per_box(grid.log_edge);
  while (double(items.size()) * per_box > kGoalBoxes * double(grid.count()) &&
         2 * grid.count() <= kMostCells) {
    const auto best = cheapest_halving(
        grid.log_edge, 0, [&](const std::array<int, 3>& halved, int) { return items_per_box(halved); });
    // each copy of a box costs time, but crowded cells would be halved one by one
    const bool crowded = double(items.size()) * per_box > 2 * kGoalBoxes * double(grid.count());
    if (!best || best->per_box > (crowded ? 1.7 : 1.5) * per_box || best->per_box > 24) break;
    grid.log_edge = best->log_edge;
    per_box = best->per_box;
    count_cells();
  }
  grid.most_items = std::size_t(kMostMisjudged * per_box * double(items.size()));
  return grid;
}

/// Cuts a region by a grid. Returns false and does nothing if the boxes touch far more cells than estimated.
bool TileCutter::cut_by_grid(const Grid& grid, Items items, Steps steps, std::size_t depth) {
  Level& level = levels_[depth];
  level.covered.assign(grid.count(), 0);
  if (steps.empty() && !mark_covered(grid, items, level)) return false;
  if (!sort_by_cell(grid, items, level)) return false;
  const bool empty_without_boxes = is_empty_without_boxes(steps);
  std::size_t c = 0;
  for (std::uint32_t z = 0; z < grid.cells[2]; ++z)
    for (std::uint32_t y = 0; y < grid.cells[1]; ++y)
      for (std::uint32_t x = 0; x < grid.cells[0]; ++x, ++c) {
        const Items own(level.sorted.data() + level.start[c], level.start[c + 1] - level.start[c]);
        if (!own.empty())
          cut_region(grid.cell(x, y, z), own, steps, depth + 1);
        else if (!empty_without_boxes || level.covered[c])
          add_covered(grid.cell(x, y, z));
      }
  return true;
}

/// Marks the cells covered by one box (UNION3, section 4, step 3a). False if the boxes touch too many cells.
bool TileCutter::mark_covered(const Grid& grid, Items items, Level& level) const {
  std::size_t touched = 0;
  const std::uint64_t edge =
      packed::pack(1u << grid.log_edge[0], 1u << grid.log_edge[1], 1u << grid.log_edge[2]);
  for (const std::uint32_t i : items) {
    const PackedBox& box = boxes_[i];
    if (!packed::all_le(edge, box.hi - box.lo)) continue;  // too small on some axis
    std::array<std::uint32_t, 3> from, to;                 // covered cells from .. to - 1
    bool some = true;
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t lo = field(box.lo, a), hi = field(box.hi, a), base = field(grid.region.lo, a);
      from[a] = lo < base ? 0 : ((lo - base) >> grid.log_edge[a]) + 1;
      to[a] = hi >= field(grid.region.hi, a) ? grid.cells[a]
              : hi < base                    ? 0
                                             : (hi - base) >> grid.log_edge[a];
      some &= from[a] < to[a];
    }
    if (!some) continue;
    touched += std::size_t{to[0] - from[0]} * (to[1] - from[1]) * (to[2] - from[2]);
    if (touched > grid.most_items) return false;
    for (std::uint32_t z = from[2]; z < to[2]; ++z)
      for (std::uint32_t y = from[1]; y < to[1]; ++y) {
        std::uint8_t* const row = level.covered.data() + (std::size_t{z} * grid.cells[1] + y) * grid.cells[0];
        std::fill(row + from[0], row + to[0], 1);
      }
  }
  return true;
}

/// Sorts the boxes by cell, by counting. A box is in every cell that it touches, except covered cells. False
/// if the boxes touch too many cells.
bool TileCutter::sort_by_cell(const Grid& grid, Items items, Level& level) const {
  level.start.assign(grid.count() + 1, 0);
  std::size_t count = 0, touched = 0;
  std::array<std::uint32_t, 3> base;
  for (int a = 0; a < 3; ++a) base[a] = field(grid.region.lo, a);
  for (const std::uint32_t i : items) {
    std::array<std::uint32_t, 3> from, to;
    for (int a = 0; a < 3; ++a) {
      from[a] = (std::max(field(boxes_[i].lo, a), base[a]) - base[a]) >> grid.log_edge[a];
      to[a] = std::min((field(boxes_[i].hi, a) - base[a]) >> grid.log_edge[a], grid.cells[a] - 1);
    }
    const std::size_t most = std::size_t{to[0] - from[0] + 1} * (to[1] - from[1] + 1) * (to[2] - from[2] + 1);
    touched += most;
    if (touched > grid.most_items) return false;
    if (level.pairs.size() < count + most) level.pairs.resize(2 * (count + most));
    for (std::uint32_t z = from[2]; z <= to[2]; ++z)
      for (std::uint32_t y = from[1]; y <= to[1]; ++y)
        for (std::uint32_t x = from[0]; x <= to[0]; ++x) {  // branch-free: it would be unpredictable
          const std::uint32_t c = (z * grid.cells[1] + y) * grid.cells[0] + x;
          const std::uint32_t open = 1u ^ level.covered[c];
          level.pairs[count] = {c, i};
          level.start[c] += open;
          count += open;
        }
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& start : level.start) start = sum += start;
  level.sorted.resize(sum);
  while (count-- > 0) level.sorted[--level.start[level.pairs[count][0]]] = level.pairs[count][1];
  return true;
}

/// Adds the cell whose boxes are stack_[begin ..], halved until it fits. Removes the boxes from the stack.
void TileCutter::halve(const PackedRegion& region, std::size_t begin, Steps steps, std::size_t depth) {
  const std::size_t end = stack_.size();
  if (begin == end) return;
  if (!may_have_vertices(region, Items(stack_).subspan(begin))) return stack_.resize(begin);
  int axis = -1;  // axis of the cut
  if (end - begin > std::min(tuning_.cell_boxes, kRanks / 2)) {
    find_own_coordinates(region, Items(stack_).subspan(begin));
    // A kernel holds so many coordinates. Few coordinates are not worth a cut, however many boxes there are.
    std::size_t most = end - begin <= tuning_.cell_boxes ? kRanks : 4;
    if (std::ranges::any_of(own_, [&](const auto& own) { return own.size() > most; }))
      for (int a = 0; a < 3; ++a) make_distinct(own_[a], field(region.lo, a), field(region.hi, a));
    for (int a = 0; a < 3; ++a)
      if (own_[a].size() > most) axis = a, most = own_[a].size();
    if (end - begin > 4 * (own_[0].size() + own_[1].size() + own_[2].size())) merge(region, begin, steps);
  }
  if (axis < 0) {
    add_cell(region, Items(stack_).subspan(begin), steps);
    stack_.resize(begin);
    return;
  }
  const std::uint32_t middle = own_[axis][own_[axis].size() / 2];
  const std::size_t items_end = stack_.size();
  for (int side = 0; side < 2; ++side) {
    PackedRegion half = region;
    (side == 0 ? half.hi : half.lo) = packed::with_field(side == 0 ? half.hi : half.lo, axis, middle);
    bool covered = false;
    for (std::size_t i = begin; i < items_end && !covered; ++i) {
      const PackedBox& box = boxes_[stack_[i]];
      if (!half.touched_by(box)) continue;
      covered = steps.empty() && half.covered_by(box);
      stack_.push_back(stack_[i]);
    }
    if (covered) {
      stack_.resize(items_end);
      add_covered(half);
    } else if (steps.empty()) {
      halve(half, items_end, steps, depth);
    } else {
      halve_expression(half, items_end, steps, depth);
    }
  }
  stack_.resize(begin);
}

/// The coordinates of the boxes that the region owns, with repetitions.
void TileCutter::find_own_coordinates(const PackedRegion& region, Items items) {
  for (int a = 0; a < 3; ++a) {
    const std::uint32_t lo = field(region.lo, a), size = field(region.hi, a) - lo;
    own_[a].resize(2 * items.size());
    std::size_t count = 0;
    for (const std::uint32_t i : items)
      for (const std::uint64_t corner : {boxes_[i].lo, boxes_[i].hi}) {
        own_[a][count] = field(corner, a);
        count += field(corner, a) - lo < size;
      }
    own_[a].resize(count);
  }
}

/// Moves boxes with different clips to the front and returns their number. Within the region, a box is its
/// clip to [lo - 1, hi], so one of several boxes with equal clips is enough.
std::size_t TileCutter::merge_equal_clips(const PackedRegion& region, std::span<std::uint32_t> items) const {
  std::vector<std::pair<PackedBox, std::uint32_t>> clips;
  for (const std::uint32_t item : items) {
    PackedBox clip;
    for (int a = 0; a < 3; ++a) {
      const PackedBox& box = boxes_[item];
      clip.lo = packed::with_field(clip.lo, a, std::max(field(box.lo, a), field(region.lo, a) - 1));
      clip.hi = packed::with_field(clip.hi, a, std::min(field(box.hi, a), field(region.hi, a)));
    }
    clips.emplace_back(clip, item);
  }
  std::ranges::sort(clips);
  std::size_t count = 0;
  for (std::size_t i = 0; i < clips.size(); ++i)
    if (i == 0 || clips[i].first != clips[i - 1].first) items[count++] = clips[i].second;
  return count;
}

void TileCutter::add_cell(const PackedRegion& region, Items items, Steps steps) {
  Cell cell{region.lo - packed::kOnes, region.hi - region.lo + packed::kOnes,
            std::uint32_t(batch_->items.size()), std::uint32_t(items.size())};
  if (sums_)
    for (int a = 0; a < 3; ++a)
      if (field(region.hi, a) == field(tile_end_, a)) cell.last |= packed::guard(a);
  batch_->cells.push_back(cell);
  for (const std::uint32_t i : items) batch_->items.push_back(first_box_ + i);
  ++statistics_.cells;
  statistics_.items += items.size();
  if (has_operands()) add_program(region, items, steps);
}

/// Adds a covered region to the sums. All of its points in the sums over vertices (kernels/cell_occupancy.k)
/// have a coordinate 0, except the upper corner of the tile, which adds what the whole tile would.
void TileCutter::add_covered(const PackedRegion& region) {
  reach_.extend({region.lo, region.hi}, region);
  ++statistics_.covered_cells;
  if (sums_ && region.hi == tile_end_) add_inside(*sums_, {packed::kOnes, tile_end_});
}

}  // namespace boxunion

#include "core/cells.hpp"

#include <bit>
#include <cmath>

namespace boxunion {
namespace {

constexpr std::uint32_t kRanks = 31;  // distinct coordinates an axis that a kernel holds
constexpr std::uint32_t kDefaultCellBoxes = 12;
constexpr std::uint32_t kMostCells = 1u << 18;  // of a tile's grid

using packed::field;

}  // namespace

void CellBatch::clear() {
  boxes.clear();
  items.clear();
  cells.clear();
  runs.clear();
}

CellStatistics& CellStatistics::operator+=(const CellStatistics& other) {
  cells += other.cells;
  covered_cells += other.covered_cells;
  items += other.items;
  return *this;
}

void TileCutter::cut(std::span<const PackedBox> boxes, const std::array<std::uint32_t, 3>& size,
                     const std::array<std::uint32_t, 3>& origin, std::uint32_t cells_per_run,
                     CellBatch& batch, LatticeSums* covered) {
  boxes_ = boxes;
  size_ = size;
  batch_ = &batch;
  covered_ = covered;
  first_box_ = std::uint32_t(batch.boxes.size());
  batch.boxes.insert(batch.boxes.end(), boxes.begin(), boxes.end());
  const std::size_t first_cell = batch.cells.size();
  choose_cell_size();
  cut_grid();
  for (std::size_t c = first_cell; c < batch.cells.size(); c += cells_per_run)
    batch.runs.push_back({std::uint32_t(c),
                          std::uint32_t(std::min<std::size_t>(cells_per_run, batch.cells.size() - c)),
                          origin});
}

void TileCutter::choose_cell_size() {
  if (tuning_.cell) {
    for (int a = 0; a < 3; ++a) cell_log_[a] = std::bit_width(tuning_.cell - 1);
  } else {
    // mean extent of the boxes, from a sample
    std::array<double, 3> extent{};
    const std::size_t step = std::max<std::size_t>(1, boxes_.size() / 256);
    std::size_t sample = 0;
    for (std::size_t i = 0; i < boxes_.size(); i += step, ++sample)
      for (int a = 0; a < 3; ++a) extent[a] += field(boxes_[i].hi, a) - field(boxes_[i].lo, a);
    for (double& e : extent) e /= double(sample);
    // halve the axis along which the cell is largest relative to the boxes while cells hold too many
    for (int a = 0; a < 3; ++a) cell_log_[a] = std::bit_width(size_[a] - 1);
    constexpr double kBoxesPerCell = 5;
    for (;;) {
      double items = double(boxes_.size()), cells = 1;
      int widest = 0;
      double most = 0;
      for (int a = 0; a < 3; ++a) {
        const double edge = double(1u << cell_log_[a]);
        items *= 1 + extent[a] / edge;
        cells *= std::max(1.0, size_[a] / edge);
        if (edge / (extent[a] + 1) > most && cell_log_[a] > 0) most = edge / (extent[a] + 1), widest = a;
      }
      if (items / cells < kBoxesPerCell || cells * 2 > kMostCells || most < 1) break;
      --cell_log_[widest];
    }
  }
  for (int a = 0; a < 3; ++a) cell_log_[a] = std::clamp(cell_log_[a], 0, int(std::bit_width(size_[a] - 1)));
  // never more cells than a tile's grid may have
  const auto cells = [&] {
    double n = 1;
    for (int a = 0; a < 3; ++a) n *= double(((size_[a] - 1) >> cell_log_[a]) + 1);
    return n;
  };
  while (cells() > kMostCells) ++*std::min_element(cell_log_.begin(), cell_log_.end());
}

void TileCutter::cut_grid() {
  std::array<std::uint32_t, 3> n;
  for (int a = 0; a < 3; ++a) n[a] = ((size_[a] - 1) >> cell_log_[a]) + 1;
  const std::uint32_t cells = n[0] * n[1] * n[2];
  const auto region = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    std::array<std::uint32_t, 3> lo{x, y, z}, hi;
    for (int a = 0; a < 3; ++a) {
      hi[a] = std::min((lo[a] + 1) << cell_log_[a], size_[a]) + 1;
      lo[a] = (lo[a] << cell_log_[a]) + 1;
    }
    return PackedRegion{packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])};
  };

  // cells that one box covers
  bool any_covered = false;
  for (const PackedBox& box : boxes_) {
    std::array<std::uint32_t, 3> from, to;  // covered cells from .. to - 1
    bool some = true;
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t lo = field(box.lo, a), hi = field(box.hi, a);
      // cell i has lo corner (i << log) + 1 > box.lo, and upper end min(.., size) + 1 <= box.hi
      from[a] = lo == 0 ? 0 : ((lo - 1) >> cell_log_[a]) + 1;
      to[a] = hi == size_[a] + 1 ? n[a] : hi == 0 ? 0 : (hi - 1) >> cell_log_[a];
      some &= from[a] < to[a];
    }
    if (!some) continue;
    if (!any_covered) covered_cell_.assign(cells, 0);
    any_covered = true;
    for (std::uint32_t z = from[2]; z < to[2]; ++z)
      for (std::uint32_t y = from[1]; y < to[1]; ++y) {
        const std::uint32_t row = (z * n[1] + y) * n[0];
        std::fill(covered_cell_.begin() + row + from[0], covered_cell_.begin() + row + to[0], 1);
      }
  }

  // boxes by cell, a counting sort
  start_.assign(cells + 1, 0);
  pairs_.clear();
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    std::array<std::uint32_t, 3> from, to;
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t lo = field(boxes_[i].lo, a), hi = field(boxes_[i].hi, a);
      from[a] = (std::max(lo, 1u) - 1) >> cell_log_[a];
      to[a] = std::min((hi - 1) >> cell_log_[a], n[a] - 1);
    }
    for (std::uint32_t z = from[2]; z <= to[2]; ++z)
      for (std::uint32_t y = from[1]; y <= to[1]; ++y)
        for (std::uint32_t x = from[0]; x <= to[0]; ++x) {
          const std::uint32_t c = (z * n[1] + y) * n[0] + x;
          if (any_covered && covered_cell_[c]) continue;
          ++start_[c];
          pairs_.push_back({c, std::uint32_t(i)});
        }
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& s : start_) {
    sum += s;
    s = sum;
  }
  sorted_.resize(sum);
  for (auto p = pairs_.rbegin(); p != pairs_.rend(); ++p) sorted_[--start_[(*p)[0]]] = (*p)[1];

  const std::uint32_t limit = tuning_.cell_boxes ? tuning_.cell_boxes : kDefaultCellBoxes;
  std::uint32_t c = 0;
  for (std::uint32_t z = 0; z < n[2]; ++z)
    for (std::uint32_t y = 0; y < n[1]; ++y)
      for (std::uint32_t x = 0; x < n[0]; ++x, ++c) {
        const std::uint32_t count = start_[c + 1] - start_[c];
        if (count == 0) {
          if (any_covered && covered_cell_[c]) add_covered(region(x, y, z));
          continue;
        }
        const std::span<const std::uint32_t> items(sorted_.data() + start_[c], count);
        if (count <= limit) {
          add_cell(region(x, y, z), items);
        } else {
          stack_.assign(items.begin(), items.end());
          cut_cell(region(x, y, z), 0);
        }
      }
}

/// Adds the cell whose boxes are stack_[begin ..], halved until it fits; removes them from the stack.
void TileCutter::cut_cell(const PackedRegion& region, std::size_t begin) {
  const std::size_t end = stack_.size();
  if (begin == end) return;
  const std::uint32_t limit = tuning_.cell_boxes ? tuning_.cell_boxes : kDefaultCellBoxes;
  int axis = -1;
  if (end - begin > std::min(limit, kRanks / 2)) {
    find_own_coordinates(region, begin);
    const std::size_t coordinates = own_[0].size() + own_[1].size() + own_[2].size();
    for (int a = 0; a < 3; ++a)
      if (own_[a].size() > (axis < 0 ? 0 : own_[axis].size())) axis = a;
    if (end - begin > 4 * coordinates) merge_equal_clips(region, begin);
    if (axis >= 0 && own_[axis].size() <= 4) axis = -1;
  }
  if (axis < 0) {
    add_cell(region, std::span(stack_).subspan(begin));
    stack_.resize(begin);
    return;
  }
  const std::uint32_t middle = own_[axis][own_[axis].size() / 2];
  if (middle == field(region.lo, axis)) {  // cannot be halved below one coordinate
    add_cell(region, std::span(stack_).subspan(begin));
    stack_.resize(begin);
    return;
  }
  const std::size_t items_end = stack_.size();
  for (int half = 0; half < 2; ++half) {
    PackedRegion child = region;
    (half == 0 ? child.hi : child.lo) = packed::with_field(half == 0 ? child.hi : child.lo, axis, middle);
    bool covered = false;
    for (std::size_t i = begin; i < items_end && !covered; ++i) {
      const PackedBox& box = boxes_[stack_[i]];
      if (!child.touched_by(box)) continue;
      covered = child.covered_by(box);
      stack_.push_back(stack_[i]);
    }
    if (covered) {
      stack_.resize(items_end);
      add_covered(child);
    } else {
      cut_cell(child, items_end);
    }
  }
  stack_.resize(begin);
}

void TileCutter::find_own_coordinates(const PackedRegion& region, std::size_t begin) {
  for (int a = 0; a < 3; ++a) {
    auto& own = own_[a];
    own.clear();
    const std::uint32_t lo = field(region.lo, a), hi = field(region.hi, a);
    for (std::size_t i = begin; i < stack_.size(); ++i) {
      const PackedBox& box = boxes_[stack_[i]];
      for (const std::uint32_t c : {field(box.lo, a), field(box.hi, a)})
        if (c >= lo && c < hi) own.push_back(c);
    }
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
  }
}

/// Within the region a box is its clip to [lo - 1, hi]: of boxes with equal clips one is enough.
void TileCutter::merge_equal_clips(const PackedRegion& region, std::size_t begin) {
  const auto clip = [&](const PackedBox& box) {
    PackedBox c;
    for (int a = 0; a < 3; ++a) {
      c.lo = packed::with_field(c.lo, a, std::max(field(box.lo, a), field(region.lo, a) - 1));
      c.hi = packed::with_field(c.hi, a, std::min(field(box.hi, a), field(region.hi, a)));
    }
    return c;
  };
  std::vector<std::pair<PackedBox, std::uint32_t>> clips;
  for (std::size_t i = begin; i < stack_.size(); ++i) clips.emplace_back(clip(boxes_[stack_[i]]), stack_[i]);
  std::sort(clips.begin(), clips.end());
  stack_.resize(begin);
  for (std::size_t i = 0; i < clips.size(); ++i)
    if (i == 0 || clips[i].first != clips[i - 1].first) stack_.push_back(clips[i].second);
}

void TileCutter::add_cell(const PackedRegion& region, std::span<const std::uint32_t> items) {
  batch_->cells.push_back({region.lo - packed::pack(1, 1, 1), region.hi - region.lo + packed::pack(1, 1, 1),
                           std::uint32_t(batch_->items.size()), std::uint32_t(items.size())});
  for (const std::uint32_t i : items) batch_->items.push_back(first_box_ + i);
  ++statistics_.cells;
  statistics_.items += items.size();
}

void TileCutter::add_covered(const PackedRegion& region) {
  ++statistics_.covered_cells;
  if (!covered_) return;
  std::uint64_t d1[3], d2[3], d3[3];
  for (int a = 0; a < 3; ++a) {
    const std::uint64_t lo = field(region.lo, a) - 1, hi = field(region.hi, a) - 1;
    d1[a] = hi - lo;
    d2[a] = hi * hi - lo * lo;
    d3[a] = hi * hi * hi - lo * lo * lo;
  }
  const auto add = [](std::int64_t& sum, std::uint64_t term) {
    sum = std::int64_t(std::uint64_t(sum) + term);
  };
  add(covered_->volume, d1[0] * d1[1] * d1[2]);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    add(covered_->first[a], d2[a] * d1[b] * d1[c]);
    add(covered_->second[a], d3[a] * d1[b] * d1[c]);
    add(covered_->second[3 + a], d2[a] * d2[b] * d1[c]);
  }
}

}  // namespace boxunion

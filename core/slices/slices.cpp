#include "core/slices/slices.hpp"

#include <algorithm>

#include "core/base/radix_sort.hpp"

namespace boxunion {
namespace {

/// Halves tiles until each fits. The rectangles of the tiles on the way down live in one stack.
class TileHalver {
 public:
  TileHalver(std::uint32_t max_coordinates, Tiles& out) : max_coordinates_(max_coordinates), out_(out) {}

  void cut(std::span<const SlabRectangle> slab) {
    stack_.assign(slab.begin(), slab.end());
    cut({0, 0, Axis::kOrdinalMax, Axis::kOrdinalMax}, 0);
  }

 private:
  /// Cuts a tile whose rectangles are stack_[begin ..], and removes these from the stack.
  void cut(const SlabRectangle& tile, std::size_t begin) {
    const std::size_t count = stack_.size() - begin;
    if (count == 0) return;
    if (2 * count > max_coordinates_) {
      find_own_coordinates(tile, begin);
      const std::size_t x = own_[0].size(), y = own_[1].size();
      if (x == 0 || y == 0) return stack_.resize(begin);  // the tile can own no vertex
      if (count > 8 * (x + y)) merge_equal_clips(tile, begin);
      if (std::max(x, y) > max_coordinates_) return cut_halves(tile, begin, x >= y ? 0 : 1);
    }
    out_.tiles.push_back({tile, std::uint32_t(out_.rectangles.size()), std::uint32_t(stack_.size() - begin)});
    out_.rectangles.insert(out_.rectangles.end(), stack_.begin() + std::ptrdiff_t(begin), stack_.end());
    stack_.resize(begin);
  }

  void cut_halves(const SlabRectangle& tile, std::size_t begin, int axis) {
    const std::size_t end = stack_.size();
    const std::uint32_t middle = own_[axis][own_[axis].size() / 2];
    for (int half = 0; half < 2; ++half) {
      SlabRectangle child = tile;
      child[half == 0 ? axis + 2 : axis] = middle;
      bool covered = false;
      for (std::size_t i = begin; i < end && !covered; ++i) {
        const SlabRectangle r = stack_[i];
        if (r[0] >= child[2] || r[1] >= child[3] || r[2] < child[0] || r[3] < child[1]) continue;
        covered = r[0] < child[0] && r[1] < child[1] && r[2] >= child[2] && r[3] >= child[3];
        stack_.push_back(r);
      }
      if (covered)
        stack_.resize(end);
      else
        cut(child, end);
    }
    stack_.resize(begin);
  }

  /// Finds the coordinates that the tile owns on each axis; sorts and merges them if there are many.
  void find_own_coordinates(const SlabRectangle& tile, std::size_t begin) {
    for (int a = 0; a < 2; ++a) {
      auto& own = own_[a];
      own.clear();
      for (std::size_t i = begin; i < stack_.size(); ++i)
        for (const std::uint32_t c : {stack_[i][a], stack_[i][a + 2]})
          if (c >= tile[a] && c < tile[a + 2]) own.push_back(c);
      if (own.size() <= max_coordinates_) continue;
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
    }
  }

  /// Merges rectangles that are equal within the tile, where a rectangle is its clip to [lo - 1, hi].
  void merge_equal_clips(const SlabRectangle& tile, std::size_t begin) {
    for (std::size_t i = begin; i < stack_.size(); ++i)
      for (int a = 0; a < 2; ++a) {
        stack_[i][a] = std::max(stack_[i][a], std::max(tile[a], 1u) - 1);
        stack_[i][a + 2] = std::min(stack_[i][a + 2], tile[a + 2]);
      }
    std::sort(stack_.begin() + std::ptrdiff_t(begin), stack_.end());
    stack_.erase(std::unique(stack_.begin() + std::ptrdiff_t(begin), stack_.end()), stack_.end());
  }

  std::uint32_t max_coordinates_;
  Tiles& out_;
  std::vector<SlabRectangle> stack_;
  std::array<std::vector<std::uint32_t>, 2> own_;
};

}  // namespace

SlabSweep::SlabSweep(std::vector<OrdinalBox> boxes) : boxes_(std::move(boxes)) {
  x_ = distinct_ordinals(boxes_, 0);
  z_ = distinct_ordinals(boxes_, 2);
  replace_by_positions(boxes_, 0, x_, 0);
  replace_by_positions(boxes_, 2, z_, 0);
  radix_sort(std::span(boxes_), [](const OrdinalBox& box) { return box.lo[2]; });
  rectangles_.assign(slabs() + 1, 0);
  for (const OrdinalBox& b : boxes_) {
    ++rectangles_[b.lo[2]];
    --rectangles_[b.hi[2]];
  }
  for (std::uint32_t i = 1; i < slabs(); ++i) rectangles_[i] += rectangles_[i - 1];
}

bool SlabSweep::next(std::size_t limit, SlabBatch& batch) {
  if (next_slab_ == slabs()) return false;
  const std::uint32_t first = next_slab_;
  batch.first = first;
  batch.offsets.assign(1, 0);
  do {
    batch.offsets.push_back(batch.offsets.back() + rectangles_[next_slab_++]);
  } while (next_slab_ < slabs() && batch.offsets.back() + rectangles_[next_slab_] <= limit);

  while (next_box_ < boxes_.size() && boxes_[next_box_].lo[2] < next_slab_)
    active_.push_back(std::uint32_t(next_box_++));
  batch.rectangles.resize(batch.offsets.back());
  std::vector<std::size_t> slot(batch.offsets.begin(), batch.offsets.end() - 1);
  for (const std::uint32_t i : active_) {
    const OrdinalBox& b = boxes_[i];
    const std::uint32_t last = std::min(b.hi[2], next_slab_);
    for (std::uint32_t s = std::max(b.lo[2], first); s < last; ++s)
      batch.rectangles[slot[s - first]++] = {b.lo[0], b.lo[1], b.hi[0], b.hi[1]};
  }
  std::erase_if(active_, [&](std::uint32_t i) { return boxes_[i].hi[2] <= next_slab_; });
  return true;
}

void cut_tiles(std::span<const SlabRectangle> slab, std::uint32_t max_coordinates, Tiles& out) {
  TileHalver(max_coordinates, out).cut(slab);
}

}  // namespace boxunion

#include "core/voxels/voxel_boxes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "core/base/parallel.hpp"
#include "core/voxels/voxel_runs.hpp"

namespace boxunion {
namespace {

struct Rectangle {
  std::uint32_t x0, x1, y0, y1;
};

/// One step of a sweep that merges equal neighbors. `open` has the indices of the items at the end of the
/// last row or slice, `items` those of the next one. Both are in the order given by compare(index, item). If
/// an item is equal to an open one and extend(index, item) agrees, it continues the open one. Otherwise
/// begin(item) starts a new one and returns its index. end(index) closes an open one that no item continues.
template <class Items, class Compare, class Extend, class Begin, class End>
void advance(std::vector<std::size_t>& open, const Items& items, Compare compare, Extend extend, Begin begin,
             End end) {
  std::vector<std::size_t> next;
  next.reserve(items.size());
  auto candidate = open.begin();
  bool continues = false;
  const auto pass = [&] {
    if (!std::exchange(continues, false)) end(*candidate);
    ++candidate;
  };
  for (const auto& item : items) {
    while (candidate != open.end() && compare(*candidate, item) < 0) pass();
    continues = candidate != open.end() && compare(*candidate, item) == 0 && extend(*candidate, item);
    next.push_back(continues ? *candidate : begin(item));
  }
  while (candidate != open.end()) pass();
  open = std::move(next);
}

/// The rectangles of a slice, sorted by y0, then x0.
std::vector<Rectangle> slice_rectangles(const VoxelRuns& runs, std::size_t first_row, std::size_t rows) {
  std::vector<Rectangle> rectangles;
  std::vector<std::size_t> open;
  for (std::uint32_t y = 0; y < rows; ++y)
    advance(
        open, runs.row(first_row + y),
        [&](std::size_t i, const Run& run) { return rectangles[i].x0 <=> run.begin; },
        [&](std::size_t i, const Run& run) {
          if (rectangles[i].x1 != run.end) return false;
          ++rectangles[i].y1;
          return true;
        },
        [&](const Run& run) {
          rectangles.push_back({run.begin, run.end, y, y + 1});
          return rectangles.size() - 1;
        },
        [](std::size_t) {});
  return rectangles;
}

bool has_whole_edges(const VoxelGrid& grid) {
  const auto fits = [](double edge) {
    return std::abs(edge) <= double(std::numeric_limits<std::int32_t>::max());
  };
  for (std::size_t a = 0; a < 3; ++a)
    if (std::trunc(grid.origin[a]) != grid.origin[a] || std::trunc(grid.spacing[a]) != grid.spacing[a] ||
        !fits(grid.origin[a]) || !fits(grid.edge(a, std::int64_t(grid.size[a]))))
      return false;
  return true;
}

/// A box of voxels, at its place in space.
template <class T>
BoxOf<T> placed(const IntegerBox& box, const VoxelGrid& grid) {
  BoxOf<T> result;
  for (std::size_t a = 0; a < 3; ++a) {
    const double first = grid.edge(a, box[a]), last = grid.edge(a, box[a + 3]);
    result[grid.axes[a]] = T(std::min(first, last));
    result[grid.axes[a] + 3] = T(std::max(first, last));
  }
  return result;
}

/// Throws Error(usage) for an invalid grid, Error(input) if an edge exceeds the range of double.
void check_edges(const VoxelGrid& grid) {
  validate(grid);
  for (std::size_t a = 0; a < 3; ++a)
    if (!std::isfinite(grid.origin[a]) || !std::isfinite(grid.edge(a, std::int64_t(grid.size[a]))))
      throw Error(ErrorKind::input,
                  fmt::format("the volume ends at {} with {} voxels of {} from {}, expected finite "
                              "numbers",
                              grid.edge(a, std::int64_t(grid.size[a])), grid.size[a], grid.spacing[a],
                              grid.origin[a]));
}

/// Collects all boxes of a sweep, in the order in which they begin.
class AllBoxes {
 public:
  std::size_t begin(const IntegerBox& box) {
    boxes.push_back(box);
    return boxes.size() - 1;
  }
  void end(std::size_t) {}
  IntegerBox& operator[](std::size_t i) { return boxes[i]; }

  std::vector<IntegerBox> boxes;
};

/// Holds the boxes that a sweep has not passed. take(box) gets the others.
template <class Take>
class OpenBoxes {
 public:
  explicit OpenBoxes(Take take) : take_(std::move(take)) {}

  std::size_t begin(const IntegerBox& box) {
    if (free_.empty()) {
      boxes_.push_back(box);
      return boxes_.size() - 1;
    }
    const std::size_t i = free_.back();
    free_.pop_back();
    boxes_[i] = box;
    return i;
  }
  void end(std::size_t i) {
    take_(boxes_[i]);
    free_.push_back(i);
  }
  IntegerBox& operator[](std::size_t i) { return boxes_[i]; }

 private:
  Take take_;
  std::vector<IntegerBox> boxes_;
  std::vector<std::size_t> free_;
};

/// Sweeps over the slices as they stream by. `boxes` takes the boxes as they begin and end.
template <class Boxes>
void sweep_slices(const VoxelStream& stream, Boxes& boxes) {
  const VoxelGrid& grid = stream.grid;
  validate(grid);
  if (grid.voxels() == 0) return;
  const std::size_t height = grid.size[1], at_once = slices_at_once(grid);
  Array<std::uint8_t> slab;
  with_memory("a slab of the volume", at_once * grid.slice(), [&] { slab.resize(at_once * grid.slice()); });
  std::vector<std::size_t> open;
  for (std::size_t first = 0; first < grid.size[2]; first += at_once) {
    const std::size_t slices = std::min(at_once, grid.size[2] - first);
    const std::span<std::uint8_t> inside = std::span(slab).first(slices * grid.slice());
    stream.read(inside);
    const VoxelRuns runs(inside, grid.size[0]);
    std::vector<std::vector<Rectangle>> rectangles(slices);
    parallel_for_each(0, slices, 1,
                      [&](std::size_t s) { rectangles[s] = slice_rectangles(runs, s * height, height); });
    for (std::size_t s = 0; s < slices; ++s)
      advance(
          open, rectangles[s],
          [&](std::size_t i, const Rectangle& r) {
            const IntegerBox& box = boxes[i];
            const auto rows = std::uint32_t(box[1]) <=> r.y0;
            return rows != 0 ? rows : std::uint32_t(box[0]) <=> r.x0;
          },
          [&](std::size_t i, const Rectangle& r) {
            IntegerBox& box = boxes[i];
            if (std::uint32_t(box[3]) != r.x1 || std::uint32_t(box[4]) != r.y1) return false;
            ++box[5];
            return true;
          },
          [&](const Rectangle& r) {
            const auto z = std::int32_t(first + s);
            return boxes.begin(
                {std::int32_t(r.x0), std::int32_t(r.y0), z, std::int32_t(r.x1), std::int32_t(r.y1), z + 1});
          },
          [&](std::size_t i) { boxes.end(i); });
  }
  for (const std::size_t i : open) boxes.end(i);
}

template <class T>
void stream_placed(const VoxelStream& stream, const std::function<void(const BoxSet&)>& take) {
  constexpr std::size_t kBlock = std::size_t{1} << 14;
  std::vector<BoxOf<T>> block;
  OpenBoxes boxes([&](const IntegerBox& box) {
    block.push_back(placed<T>(box, stream.grid));
    if (block.size() == kBlock) take(std::exchange(block, {}));
  });
  sweep_slices(stream, boxes);
  take(std::move(block));
}

}  // namespace

std::vector<IntegerBox> index_boxes(const VoxelStream& stream) {
  AllBoxes all;
  sweep_slices(stream, all);
  return std::move(all.boxes);
}

BoxSet voxel_boxes(const VoxelStream& stream) {
  const VoxelGrid& grid = stream.grid;
  check_edges(grid);
  std::vector<IntegerBox> boxes = index_boxes(stream);
  constexpr std::size_t kGrain = std::size_t{1} << 14;
  if (has_whole_edges(grid)) {
    parallel_for_each(0, boxes.size(), kGrain,
                      [&](std::size_t i) { boxes[i] = placed<std::int32_t>(boxes[i], grid); });
    return boxes;
  }
  std::vector<Box> result = with_memory("the boxes of the volume", boxes.size() * sizeof(Box),
                                        [&] { return std::vector<Box>(boxes.size()); });
  parallel_for_each(0, boxes.size(), kGrain,
                    [&](std::size_t i) { result[i] = placed<double>(boxes[i], grid); });
  return result;
}

void stream_voxel_boxes(const VoxelStream& stream, const std::function<void(const BoxSet&)>& take) {
  check_edges(stream.grid);
  has_whole_edges(stream.grid) ? stream_placed<std::int32_t>(stream, take)
                               : stream_placed<double>(stream, take);
}

std::uint64_t stream_bytes(const VoxelGrid& grid) {
  // runs and rectangles for every other voxel of a few slices, boxes for those of two slices
  constexpr std::uint64_t kOfSlices = 1 + (sizeof(Run) + sizeof(Rectangle)) / 2;
  constexpr std::uint64_t kOfSlice = sizeof(IntegerBox) + 2 * sizeof(std::size_t);
  return grid.slice() * (slices_at_once(grid) * kOfSlices + kOfSlice);
}

}  // namespace boxunion

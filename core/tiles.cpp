#include "core/tiles.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "core/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBoxesPerTile = 12000;  // keeps a tile's boxes and items in a core's cache
constexpr std::size_t kMostTiles = 1u << 20;
constexpr std::size_t kGrain = 1u << 15;

/// Memory for `count` boxes in large pages where the system has them: the boxes are written in random order.
PackedBox* allocate_boxes(std::size_t count) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const std::size_t bytes = (std::max<std::size_t>(count, 1) * sizeof(PackedBox) + kPage - 1) / kPage * kPage;
  void* memory = std::aligned_alloc(kPage, bytes);
  if (!memory) throw std::bad_alloc();
#if defined(__linux__)
  madvise(memory, bytes, MADV_HUGEPAGE);
#endif
  return static_cast<PackedBox*>(memory);
}

}  // namespace

TileGrid::Plan TileGrid::plan(const OrdinalSource& source, const std::array<std::uint32_t, 3>& counts,
                              int max_log_edge) {
  Plan plan;
  for (int a = 0; a < 3; ++a) {
    plan.log_edge[a] = std::min(max_log_edge, int(std::bit_width(counts[a])));
  }
  std::vector<OrdinalBox> sample;
  const std::size_t n = source.size(), step = n / 2048 + 1;
  for (std::size_t i = 0; i < n; i += step)
    source.read(i, i + 1, [&](const OrdinalBox& box) { sample.push_back(box); });
  const auto touched = [&](const std::array<int, 3>& log_edge) {  // tiles a box, on average
    double sum = 0;
    for (const OrdinalBox& box : sample) {
      double tiles = 1;
      for (int a = 0; a < 3; ++a) tiles *= 1 + (box.hi[a] >> log_edge[a]) - (box.lo[a] >> log_edge[a]);
      sum += tiles;
    }
    return sample.empty() ? 1 : sum / double(sample.size());
  };
  const auto count_tiles = [&] {
    for (int a = 0; a < 3; ++a) plan.tiles[a] = (counts[a] >> plan.log_edge[a]) + 1;
  };
  count_tiles();
  plan.touched = touched(plan.log_edge);
  while (n / kBoxesPerTile > plan.count() && 2 * plan.count() <= kMostTiles) {
    // halve the axis that duplicates the fewest boxes
    int best = -1;
    double best_touched = 0;
    for (int a = 0; a < 3; ++a) {
      if (plan.log_edge[a] <= 4) continue;
      auto log_edge = plan.log_edge;
      --log_edge[a];
      const double t = touched(log_edge) - 1e-9 * log_edge[a];  // the longest of equals
      if (best < 0 || t < best_touched) best = a, best_touched = t;
    }
    if (best < 0 || best_touched > std::max(1.4, 1.1 * plan.touched)) break;
    --plan.log_edge[best];
    plan.touched = best_touched;
    count_tiles();
  }
  return plan;
}

TileGrid::TileGrid(const OrdinalSource& source, const Plan& plan) : plan_(plan), boxes_(nullptr, std::free) {
  const std::array<std::uint32_t, 3> edge_ = edge();
  const std::size_t tiles = plan.count(), n = source.size();
  const auto tile_of = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (std::size_t{z} * plan_.tiles[1] + y) * plan_.tiles[0] + x;
  };
  /// Calls f(x, y, z, tile) for every tile that the box touches.
  const auto each_tile = [&](const OrdinalBox& box, auto&& f) {
    std::array<std::uint32_t, 3> from, to;
    for (int a = 0; a < 3; ++a) {
      from[a] = box.lo[a] >> plan_.log_edge[a];
      to[a] = box.hi[a] >> plan_.log_edge[a];
    }
    if (from == to) return f(from[0], from[1], from[2], tile_of(from[0], from[1], from[2]));
    for (std::uint32_t z = from[2]; z <= to[2]; ++z)
      for (std::uint32_t y = from[1]; y <= to[1]; ++y)
        for (std::uint32_t x = from[0]; x <= to[0]; ++x) f(x, y, z, tile_of(x, y, z));
  };
  const auto is_wide = [&](const OrdinalBox& box) {
    return box.hi[0] - box.lo[0] > edge_[0] && box.hi[1] - box.lo[1] > edge_[1] &&
           box.hi[2] - box.lo[2] > edge_[2];
  };

  // bounds, and the tiles that one box covers
  const OrdinalBox nothing{{Axis::kOrdinalMax, Axis::kOrdinalMax, Axis::kOrdinalMax}, {0, 0, 0}};
  struct Pass {
    OrdinalBox bounds;
    std::vector<OrdinalBox> wide;
  };
  const Pass pass = parallel_reduce(
      0, n, kGrain, Pass{nothing, {}},
      [&](std::size_t begin, std::size_t end, Pass p) {
        source.read(begin, end, [&](const OrdinalBox& box) {
          for (int a = 0; a < 3; ++a) {
            p.bounds.lo[a] = std::min(p.bounds.lo[a], box.lo[a]);
            p.bounds.hi[a] = std::max(p.bounds.hi[a], box.hi[a]);
          }
          if (is_wide(box)) p.wide.push_back(box);
        });
        return p;
      },
      [](Pass p, const Pass& q) {
        for (int a = 0; a < 3; ++a) {
          p.bounds.lo[a] = std::min(p.bounds.lo[a], q.bounds.lo[a]);
          p.bounds.hi[a] = std::max(p.bounds.hi[a], q.bounds.hi[a]);
        }
        p.wide.insert(p.wide.end(), q.wide.begin(), q.wide.end());
        return p;
      });
  bounds_ = pass.bounds;
  if (!pass.wide.empty()) covered_.assign(tiles, 0);
  for (const OrdinalBox& box : pass.wide) {
    std::array<std::uint32_t, 3> from,
        to;  // covered tiles from .. to - 1: box.lo < corner, corner + edge <= box.hi
    for (int a = 0; a < 3; ++a) {
      from[a] = (box.lo[a] >> plan_.log_edge[a]) + 1;
      to[a] = box.hi[a] >> plan_.log_edge[a];
    }
    for (std::uint32_t z = from[2]; z < to[2]; ++z)
      for (std::uint32_t y = from[1]; y < to[1]; ++y)
        for (std::uint32_t x = from[0]; x < to[0]; ++x) covered_[tile_of(x, y, z)] = 1;
  }

  // a counting sort: each chunk of the boxes counts, then writes its own places in every tile
  const std::size_t chunks = std::clamp<std::size_t>(n / (4 * tiles + 1), 1, 8);
  const auto chunk_begin = [&](std::size_t c) { return n * c / chunks; };
  std::vector<std::vector<std::size_t>> place(chunks);
  parallel_ranges(0, chunks, 1, [&](std::size_t first_chunk, std::size_t end_chunk) {
    for (std::size_t c = first_chunk; c < end_chunk; ++c) {
      auto& count = place[c];
      count.assign(tiles, 0);
      source.read(chunk_begin(c), chunk_begin(c + 1), [&](const OrdinalBox& box) {
        each_tile(box, [&](auto, auto, auto, std::size_t tile) { count[tile] += !covered(tile); });
      });
    }
  });
  first_.resize(tiles + 1);
  std::size_t sum = 0;
  for (std::size_t t = 0; t < tiles; ++t) {
    first_[t] = sum;
    for (auto& chunk : place) sum += std::exchange(chunk[t], sum);
  }
  first_[tiles] = sum;
  boxes_.reset(allocate_boxes(sum));
  parallel_ranges(0, chunks, 1, [&](std::size_t first_chunk, std::size_t end_chunk) {
    for (std::size_t c = first_chunk; c < end_chunk; ++c)
      source.read(chunk_begin(c), chunk_begin(c + 1), [&](const OrdinalBox& box) {
        each_tile(box, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t tile) {
          if (covered(tile)) return;
          const std::array<std::uint32_t, 3> at{x, y, z};
          std::array<std::uint32_t, 3> lo, hi;  // packed coordinates count from 1 at the corner
          for (int a = 0; a < 3; ++a) {
            const std::uint32_t corner = at[a] << plan_.log_edge[a];
            lo[a] = box.lo[a] < corner ? 0 : box.lo[a] - corner + 1;
            hi[a] = std::min(box.hi[a] - corner, edge_[a]) + 1;
          }
          boxes_.get()[place[c][tile]++] = {packed::pack(lo[0], lo[1], lo[2]),
                                            packed::pack(hi[0], hi[1], hi[2])};
        });
      });
  });
}

std::array<std::uint32_t, 3> TileGrid::corner(std::size_t tile) const {
  const std::size_t x = tile % plan_.tiles[0], y = tile / plan_.tiles[0] % plan_.tiles[1],
                    z = tile / plan_.tiles[0] / plan_.tiles[1];
  return {std::uint32_t(x) << plan_.log_edge[0], std::uint32_t(y) << plan_.log_edge[1],
          std::uint32_t(z) << plan_.log_edge[2]};
}

std::array<std::uint32_t, 3> TileGrid::edge() const {
  return {1u << plan_.log_edge[0], 1u << plan_.log_edge[1], 1u << plan_.log_edge[2]};
}

}  // namespace boxunion

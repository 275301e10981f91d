#include "core/tiles.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "core/error.hpp"
#include "core/memory.hpp"
#include "core/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBoxesPerTile =
    4000;  // keeps a tile's boxes and items in a core's cache, its sweeps narrow
constexpr std::size_t kMostTiles = 1u << 20;

/// Memory for `count` boxes in large pages where the system has them: the boxes are written in random order.
PackedBox* allocate_boxes(std::size_t count) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const std::size_t bytes = (std::max<std::size_t>(count, 1) * sizeof(PackedBox) + kPage - 1) / kPage * kPage;
  void* memory = std::aligned_alloc(kPage, bytes);
  if (!memory) throw_out_of_memory("sorting the boxes into tiles", bytes);
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
    for (int a = 2; a >= 0; --a) {  // of equals the longest, x last: see Clusters
      if (plan.log_edge[a] <= 4) continue;
      auto log_edge = plan.log_edge;
      --log_edge[a];
      const double t = touched(log_edge) - 1e-9 * log_edge[a];
      if (best < 0 || t < best_touched) best = a, best_touched = t;
    }
    if (best < 0 || best_touched > std::max(1.4, 1.1 * plan.touched)) break;
    --plan.log_edge[best];
    plan.touched = best_touched;
    count_tiles();
  }
  return plan;
}

TileGrid::TileGrid(const OrdinalSource& source, const Plan& plan, const std::atomic<bool>* interrupted)
    : plan_(plan), interrupted_(interrupted), boxes_(nullptr, std::free) {
  // a counting sort: each chunk of the boxes counts, then writes its own places in every tile
  const std::size_t tiles = plan.count(), n = source.size();
  std::vector<Chunk> chunks(std::clamp<std::size_t>(n / (4 * tiles + 1), 1, 8));
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    chunks[c].begin = n * c / chunks.size();
    chunks[c].end = n * (c + 1) / chunks.size();
  }
  count(source, chunks);
  if (mark_covered(chunks)) count(source, chunks);  // again, without the covered tiles

  bounds_ = {{Axis::kOrdinalMax, Axis::kOrdinalMax, Axis::kOrdinalMax}, {0, 0, 0}};
  for (const Chunk& chunk : chunks)
    for (int a = 0; a < 3; ++a) {
      bounds_.lo[a] = std::min(bounds_.lo[a], chunk.bounds.lo[a]);
      bounds_.hi[a] = std::max(bounds_.hi[a], chunk.bounds.hi[a]);
    }
  first_.resize(tiles + 1);
  std::size_t sum = 0;
  for (std::size_t t = 0; t < tiles; ++t) {
    first_[t] = sum;
    for (Chunk& chunk : chunks) sum += std::exchange(chunk.place[t], sum);
  }
  first_[tiles] = sum;
  boxes_.reset(allocate_boxes(sum));
  parallel_ranges(0, chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) scatter(source, chunks[c]);
  });
}

/// Calls f(box) for a chunk's boxes; sees an interruption soon.
template <class F>
void TileGrid::read(const OrdinalSource& source, const Chunk& chunk, F&& f) const {
  constexpr std::size_t kPiece = 1u << 15;
  for (std::size_t i = chunk.begin; i < chunk.end; i += kPiece) {
    if (interrupted_ && *interrupted_) throw Error(ErrorKind::interrupted, "interrupted");
    source.read(i, std::min(i + kPiece, chunk.end), f);
  }
}

/// Calls f(x, y, z, tile) for every tile that the box touches and that is not covered.
template <class F>
void TileGrid::each_tile(const OrdinalBox& box, F&& f) const {
  std::array<std::uint32_t, 3> from, to;
  for (int a = 0; a < 3; ++a) {
    from[a] = box.lo[a] >> plan_.log_edge[a];
    to[a] = box.hi[a] >> plan_.log_edge[a];
  }
  for (std::uint32_t z = from[2]; z <= to[2]; ++z)
    for (std::uint32_t y = from[1]; y <= to[1]; ++y)
      for (std::uint32_t x = from[0]; x <= to[0]; ++x)
        if (const std::size_t tile = index(x, y, z); !covered(tile)) f(x, y, z, tile);
}

/// Counts each chunk's boxes by tile; notes its bounds and the boxes that may cover a tile.
void TileGrid::count(const OrdinalSource& source, std::vector<Chunk>& chunks) const {
  const std::array<std::uint32_t, 3> edges = edge();
  parallel_ranges(0, chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Chunk& chunk = chunks[c];
      chunk.place.assign(plan_.count(), 0);
      chunk.wide.clear();
      OrdinalBox bounds{{Axis::kOrdinalMax, Axis::kOrdinalMax, Axis::kOrdinalMax}, {0, 0, 0}};
      read(source, chunk, [&](const OrdinalBox& box) {
        bool wide = true;
        for (int a = 0; a < 3; ++a) {
          bounds.lo[a] = std::min(bounds.lo[a], box.lo[a]);
          bounds.hi[a] = std::max(bounds.hi[a], box.hi[a]);
          wide &= box.hi[a] - box.lo[a] > edges[a];
        }
        if (wide) chunk.wide.push_back(box);
        each_tile(box, [&](auto, auto, auto, std::size_t tile) { ++chunk.place[tile]; });
      });
      chunk.bounds = bounds;
    }
  });
}

/// Marks the tiles that one box covers (UNION3, section 4, step 3a). False if there are none.
bool TileGrid::mark_covered(const std::vector<Chunk>& chunks) {
  for (const Chunk& chunk : chunks)
    for (const OrdinalBox& box : chunk.wide) {
      std::array<std::uint32_t, 3> from, to;  // covered tiles from .. to - 1
      for (int a = 0; a < 3; ++a) {
        from[a] = (box.lo[a] >> plan_.log_edge[a]) + 1;
        to[a] = box.hi[a] >> plan_.log_edge[a];
      }
      for (std::uint32_t z = from[2]; z < to[2]; ++z)
        for (std::uint32_t y = from[1]; y < to[1]; ++y)
          for (std::uint32_t x = from[0]; x < to[0]; ++x) {
            if (covered_.empty()) covered_.assign(plan_.count(), 0);
            covered_[index(x, y, z)] = 1;
          }
    }
  return !covered_.empty();
}

/// Writes a chunk's boxes to their tiles, some at a time, because memory likes whole lines better.
void TileGrid::scatter(const OrdinalSource& source, Chunk& chunk) {
  constexpr std::size_t kStaged = 8, kMostStaged = 1u << 13;
  const bool staged = plan_.count() <= kMostStaged && chunk.end - chunk.begin > 4 * plan_.count();
  std::vector<PackedBox> stage(staged ? kStaged * plan_.count() : 0);
  std::vector<std::uint8_t> filled(staged ? plan_.count() : 0);
  const std::array<std::uint32_t, 3> edges = edge();
  read(source, chunk, [&](const OrdinalBox& box) {
    each_tile(box, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t tile) {
      const std::array<std::uint32_t, 3> at{x, y, z};
      std::array<std::uint32_t, 3> lo, hi;  // packed coordinates count from 1 at the corner
      for (int a = 0; a < 3; ++a) {
        const std::uint32_t corner = at[a] << plan_.log_edge[a];
        lo[a] = box.lo[a] < corner ? 0 : box.lo[a] - corner + 1;
        hi[a] = std::min(box.hi[a] - corner, edges[a]) + 1;
      }
      const PackedBox packed_box{packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])};
      if (!staged) {
        boxes_.get()[chunk.place[tile]++] = packed_box;
        return;
      }
      PackedBox* const slots = stage.data() + kStaged * tile;
      slots[filled[tile]] = packed_box;
      if (++filled[tile] < kStaged) return;
      std::copy_n(slots, kStaged, boxes_.get() + chunk.place[tile]);
      chunk.place[tile] += kStaged;
      filled[tile] = 0;
    });
  });
  for (std::size_t t = 0; t < filled.size(); ++t)
    std::copy_n(stage.data() + kStaged * t, filled[t], boxes_.get() + chunk.place[t]);
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

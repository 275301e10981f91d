#include "core/cells/tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"
#include "core/cells/halving.hpp"

namespace boxunion {
namespace {

constexpr double kMostInTile = 2000;  // so many boxes stay in cache, and sweeps over them are narrow
constexpr double kEnoughTiles = 8;    // for several threads
constexpr std::size_t kMostTiles = 1u << 20;
constexpr int kLeastLogEdge = 4;
constexpr double kMostMisjudged = 2;   // factor of the estimate of touched tiles
constexpr double kFewTiles = 1 << 14;  // so many tiles are harmless, whatever the estimate

constexpr std::size_t kMostChunks = 8;
constexpr double kLeastBlock = 8, kMostBlock = 64;  // words

}  // namespace

TileGrid::Plan TileGrid::plan(std::span<const OrdinalSource> sources,
                              const std::array<std::uint32_t, 3>& counts, int max_log_edge, std::size_t least,
                              std::size_t sample) {
  Plan whole =
      plan(sources, {{0, 0, 0}, {counts[0] + 1, counts[1] + 1, counts[2] + 1}}, max_log_edge, least, sample);
  whole.end.fill(Axis::kOrdinalMax);  // nothing lies beyond it
  return whole;
}

TileGrid::Plan TileGrid::plan(std::span<const OrdinalSource> sources, const OrdinalBox& region,
                              int max_log_edge, std::size_t least, std::size_t most_sampled) {
  Plan plan;
  plan.end = region.hi;
  for (int a = 0; a < 3; ++a)
    plan.log_edge[a] = std::min(max_log_edge, int(std::bit_width(region.hi[a] - region.lo[a] - 1)));
  std::vector<OrdinalBox> sample;
  std::size_t n = 0;
  for (const OrdinalSource& source : sources) n += source.size();
  for (const OrdinalSource& source : sources)
    Sample(source.size(), std::max<std::size_t>(1, source.size() * most_sampled / std::max(n, most_sampled)))
        .each([&](std::size_t i) {
          source.read(i, i + 1, [&](const OrdinalBox& box) { sample.push_back(box); });
        });
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
    for (int a = 0; a < 3; ++a) {
      plan.first[a] = region.lo[a] >> plan.log_edge[a];
      plan.tiles[a] = ((region.hi[a] - 1) >> plan.log_edge[a]) - plan.first[a] + 1;
    }
  };
  count_tiles();
  plan.touched = touched(plan.log_edge);
  const double wanted = std::clamp(double(n) / kEnoughTiles, double(least), kMostInTile);
  const auto in_full_tile = [&] {  // average number of boxes in a tile that lies within the region
    double boxes = double(n);
    for (int a = 0; a < 3; ++a)
      boxes *= std::min(1.0, std::ldexp(1.0, plan.log_edge[a]) / double(region.hi[a] - region.lo[a]));
    return boxes;
  };
  while (in_full_tile() > wanted && 2 * plan.count() <= kMostTiles) {
    // of equal axes the longest, x last: see Clusters
    const auto best = cheapest_halving(
        plan.log_edge, kLeastLogEdge,
        [&](const std::array<int, 3>& halved, int axis) { return touched(halved) - 1e-9 * halved[axis]; });
    if (!best || best->per_box > std::max(1.4, 1.1 * plan.touched)) break;
    plan.log_edge = best->log_edge;
    plan.touched = best->per_box;
    count_tiles();
  }
  plan.most_touched = kMostMisjudged * plan.touched * double(n) + kFewTiles;
  return plan;
}

TileGrid::TileGrid(const OrdinalSource& source, const Plan& plan)
    : plan_(plan),
      words_(std::ranges::max(plan.log_edge)),
      chunks_(std::clamp<std::size_t>(source.size() / (4 * plan.count() + 1), 1, kMostChunks)) {
  first_index_ = index(plan.first[0], plan.first[1], plan.first[2]);
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    chunks_[c].begin = source.size() * c / chunks_.size();
    chunks_[c].end = source.size() * (c + 1) / chunks_.size();
  }
  // at most half of a share may be empty, so small shares have small blocks
  const double share = double(source.size()) * plan.touched / double(plan.count() * chunks_.size());
  block_ = std::bit_floor(std::uint32_t(std::clamp(share, kLeastBlock, kMostBlock)));
  for (Chunk& chunk : chunks_) chunk.most_touched = plan.most_touched / 2;  // boxes may be sorted by size
  covered_.assign(size(), 0);
  parallel_for_each(0, chunks_.size(), 1, [&](std::size_t c) { scatter(source, chunks_[c]); });
  double touched = 0;
  for (const Chunk& chunk : chunks_) {
    touched += chunk.touched;
    misjudged_ |= chunk.touched > chunk.most_touched;
  }
  misjudged_ |= touched > plan.most_touched;
  if (misjudged_) return;
  bounds_ = chunks_[0].bounds;
  for (const Chunk& chunk : chunks_)
    for (int a = 0; a < 3; ++a) {
      bounds_.lo[a] = std::min(bounds_.lo[a], chunk.bounds.lo[a]);
      bounds_.hi[a] = std::max(bounds_.hi[a], chunk.bounds.hi[a]);
    }
  collect_pieces();
}

std::size_t TileGrid::words(std::size_t tile) const {
  std::size_t sum = 0;
  for (std::size_t p = first_[tile]; p < first_[tile + 1]; ++p) sum += pieces_[p].size();
  return sum;
}

void TileGrid::gather(std::size_t tile, std::vector<PackedBox>& boxes) const {
  const std::size_t before = boxes.size();
  boxes.resize(before + words(tile));
  PackedBox* out = boxes.data() + before;
  std::uint64_t first = 0;
  for (std::size_t p = first_[tile]; p < first_[tile + 1]; ++p) {
    if (p + 2 < pieces_.size())  // prefetch, because pieces are scattered
      for (std::size_t i = 0; i < pieces_[p + 2].size(); i += 8) __builtin_prefetch(&pieces_[p + 2][i]);
    for (const std::uint64_t word : pieces_[p]) out += words_.decode(word, first, *out);
  }
  boxes.resize(std::size_t(out - boxes.data()));
}

/// Calls f(box) for the boxes of a chunk. Checks for an interrupt now and then.
template <class F>
void TileGrid::read(const OrdinalSource& source, const Chunk& chunk, F&& f) const {
  constexpr std::size_t kPiece = 1u << 15;
  for (std::size_t i = chunk.begin; i < chunk.end; i += kPiece) {
    Interruptible::check();
    if (chunk.touched > chunk.most_touched) return;
    source.read(i, std::min(i + kPiece, chunk.end), f);
  }
}

/// Puts the boxes of a chunk into its shares of the tiles, and extends its bounds.
void TileGrid::scatter(const OrdinalSource& source, Chunk& chunk) {
  chunk.shares.resize(size());
  OrdinalBox bounds{{Axis::kOrdinalMax, Axis::kOrdinalMax, Axis::kOrdinalMax}, {0, 0, 0}};
  const std::array<std::uint32_t, 3> edges = full_edge();
  const std::uint64_t ones = packed::pack(1, 1, 1);  // packed coordinates count from 1 at the corner
  read(source, chunk, [&](const OrdinalBox& box) {
    std::uint32_t across = 0;  // borders of tiles that the box crosses
    std::array<std::uint32_t, 3> at;
    for (int a = 0; a < 3; ++a) {
      bounds.lo[a] = std::min(bounds.lo[a], box.lo[a]);
      bounds.hi[a] = std::max(bounds.hi[a], box.hi[a]);
      at[a] = box.lo[a] >> plan_.log_edge[a];
      across |= at[a] ^ box.hi[a] >> plan_.log_edge[a];
    }
    if (across) [[unlikely]]
      return scatter_wide(box, chunk);
    const auto within = [&](const std::array<std::uint32_t, 3>& p) {
      return packed::pack(p[0] & (edges[0] - 1), p[1] & (edges[1] - 1), p[2] & (edges[2] - 1)) + ones;
    };
    put(chunk, index(at[0], at[1], at[2]), {within(box.lo), within(box.hi)});
  });
  put_pending(chunk);
  chunk.bounds = bounds;
}

/// The same for a box that touches several tiles. Marks the tiles that the box covers (UNION3, section 4,
/// step 3a).
void TileGrid::scatter_wide(const OrdinalBox& box, Chunk& chunk) {
  const TileRange all = touched(box);
  TileRange range = all;
  const std::array<std::uint32_t, 3> edges = full_edge();
  for (int a = 0; a < 3; ++a) {
    range.from[a] = std::max(range.from[a], plan_.first[a]);
    range.to[a] = std::min(range.to[a], plan_.first[a] + plan_.tiles[a] - 1);
  }
  double touched = 1;
  for (int a = 0; a < 3; ++a) touched *= double(range.to[a]) - double(range.from[a]) + 1;
  chunk.touched += touched;
  if (chunk.touched > chunk.most_touched) return;
  const auto inside = [&](std::uint32_t at, int a) { return all.from[a] < at && at < all.to[a]; };
  for (std::uint32_t z = range.from[2]; z <= range.to[2]; ++z)
    for (std::uint32_t y = range.from[1]; y <= range.to[1]; ++y)
      for (std::uint32_t x = range.from[0]; x <= range.to[0]; ++x) {
        const std::size_t tile = index(x, y, z);
        const std::atomic_ref covered(covered_[tile]);
        if (covered.load(std::memory_order_relaxed)) continue;
        if (inside(x, 0) && inside(y, 1) && inside(z, 2)) {
          covered.store(1, std::memory_order_relaxed);
          continue;
        }
        const std::array<std::uint32_t, 3> at{x, y, z};
        std::array<std::uint32_t, 3> lo, hi;
        for (int a = 0; a < 3; ++a) {
          const std::uint32_t corner = at[a] << plan_.log_edge[a];
          lo[a] = box.lo[a] < corner ? 0 : box.lo[a] - corner + 1;
          hi[a] = std::min(box.hi[a] - corner, edges[a]) + 1;
        }
        put(chunk, tile, {packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])});
      }
}

void TileGrid::put_pending(Chunk& chunk) const {
  const std::size_t n = std::exchange(chunk.pending_count, 0);
  std::array<std::uint64_t*, kPending> places;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t tile = chunk.pending[i].tile;
    Share& share = chunk.shares[tile];
    const std::uint32_t place = share.count++ & (block_ - 1);
    if (place == 0) add_block(chunk, tile);
    places[i] = share.last + place;
    __builtin_prefetch(places[i], 1);
  }
  for (std::size_t i = 0; i < n; ++i) *places[i] = chunk.pending[i].word;
}

/// Appends an empty block to the chunk's share of a tile. The first pool of blocks should be enough.
void TileGrid::add_block(Chunk& chunk, std::size_t tile) const {
  if (chunk.pools.empty() || chunk.used == chunk.pools.back().size()) {
    const double words = double(chunk.end - chunk.begin) * plan_.touched / (chunk.pools.empty() ? 1 : 8);
    const std::size_t tiles = chunk.pools.empty() ? std::min(size(), chunk.end - chunk.begin) : 1;
    const std::size_t blocks = std::size_t(words) / block_ + tiles / 2 + 1;
    with_memory("sorting the boxes into tiles", blocks * block_ * sizeof(std::uint64_t),
                [&] { return chunk.pools.emplace_back(blocks * block_).size(); });
    chunk.used = 0;
  }
  std::uint64_t* const block = chunk.pools.back().data() + chunk.used;
  chunk.used += block_;
  chunk.shares[tile].last = block;
  chunk.blocks.emplace_back(block, std::uint32_t(tile));
}

/// Sorts the blocks of all chunks by tile, by counting.
void TileGrid::collect_pieces() {
  first_.assign(size() + 2, 0);
  for (const Chunk& chunk : chunks_)
    for (const auto& [block, tile] : chunk.blocks) first_[tile + 2] += !covered_[tile];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  pieces_.resize(first_.back());
  for (const Chunk& chunk : chunks_)
    for (const auto& [block, tile] : chunk.blocks) {
      if (covered_[tile]) continue;
      const Share& share = chunk.shares[tile];
      pieces_[first_[tile + 1]++] = {block,
                                     block == share.last ? ((share.count - 1) & (block_ - 1)) + 1 : block_};
    }
}

std::array<std::uint32_t, 3> TileGrid::corner(std::size_t tile) const {
  const std::size_t x = tile % plan_.tiles[0], y = tile / plan_.tiles[0] % plan_.tiles[1],
                    z = tile / plan_.tiles[0] / plan_.tiles[1];
  return {(plan_.first[0] + std::uint32_t(x)) << plan_.log_edge[0],
          (plan_.first[1] + std::uint32_t(y)) << plan_.log_edge[1],
          (plan_.first[2] + std::uint32_t(z)) << plan_.log_edge[2]};
}

std::array<std::uint32_t, 3> TileGrid::edge(std::size_t tile) const {
  const std::array<std::uint32_t, 3> at = corner(tile);
  std::array<std::uint32_t, 3> edges = full_edge();
  for (int a = 0; a < 3; ++a) edges[a] = std::min(edges[a], plan_.end[a] - at[a]);
  return edges;
}

}  // namespace boxunion

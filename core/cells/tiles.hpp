#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/memory.hpp"
#include "core/boxes/axis.hpp"
#include "core/cells/packed.hpp"

namespace boxunion {

/// Boxes in ordinals, wherever they come from: computed from a lattice on the fly, or kept.
///
/// read(begin, end, f) calls f(box) for the boxes begin .. end - 1 that are not degenerate, in order.
class OrdinalSource {
 public:
  /// Boxes on three lattices; `boxes` and `axes` must outlive the source.
  OrdinalSource(const BoxSet& boxes, const Axes& axes) : boxes_(&boxes), axes_(&axes), size_(boxes.size()) {}
  /// Kept boxes; `kept` must outlive the source.
  explicit OrdinalSource(std::span<const OrdinalBox> kept) : kept_(kept), size_(kept.size()) {}

  std::size_t size() const { return size_; }

  template <class F>
  void read(std::size_t begin, std::size_t end, F&& f) const;

 private:
  const BoxSet* boxes_ = nullptr;
  const Axes* axes_ = nullptr;
  std::span<const OrdinalBox> kept_;
  std::size_t size_;
};

/// The boxes of a run, sorted into the tiles of a uniform grid, most of them packed in one word. A box is in
/// every tile that it touches; a tile that one box covers holds none. A tile's memory grows by blocks, so the
/// boxes are put in place in one pass, without counting them first.
class TileGrid {
 public:
  /// How the ordinals are cut; tile i of an axis begins at ordinal (first + i) * 2^log_edge.
  struct Plan {
    std::array<int, 3> log_edge{};         ///< log2 of a tile's edge, at most 19
    std::array<std::uint32_t, 3> first{};  ///< by axis
    std::array<std::uint32_t, 3> tiles{};  ///< by axis
    std::array<std::uint32_t, 3> end{};    ///< where the last tile ends, however long it would be
    double touched = 1;                    ///< tiles that a box touches, on average, by a sample
    double most_touched = 0;  ///< limit for all boxes of all sources together; beyond it the plan is wrong
    std::size_t count() const { return std::size_t{tiles[0]} * tiles[1] * tiles[2]; }
  };

  /// Chooses tiles for ordinals 1 .. counts[a]: as many as keep a tile's boxes in cache, with edges of at
  /// most 2^max_log_edge ordinals; of few boxes enough for several threads, if a tile still has `least`.
  /// The boxes are those of all sources, for each of which a grid may then be made. `sample` of them are
  /// looked at.
  static Plan plan(std::span<const OrdinalSource> sources, const std::array<std::uint32_t, 3>& counts,
                   int max_log_edge, std::size_t least, std::size_t sample = kSample);
  /// The same for the points lo <= p < hi of a region only; lo must be a multiple of 2^max_log_edge, and no
  /// box reach further than from lo - 1 to hi.
  static Plan plan(std::span<const OrdinalSource> sources, const OrdinalBox& region, int max_log_edge,
                   std::size_t least, std::size_t sample = kSample);
  static constexpr std::size_t kSample = 512;

  /// Gives up, and then holds nothing of use, where its boxes touch twice as many tiles as the plan says of
  /// all. Throws Error(resources) where memory does not suffice, and Error(interrupted) soon after
  /// `interrupted` becomes true.
  TileGrid(const OrdinalSource& source, const Plan& plan, const std::atomic<bool>* interrupted = nullptr);

  /// True if it has given up: it takes another plan, by a larger sample.
  bool misjudged() const { return misjudged_; }
  std::size_t size() const { return plan_.count(); }
  /// Number of words that the boxes of a tile take: as many as there are boxes, up to twice as many if they
  /// are not short.
  std::size_t words(std::size_t tile) const;
  /// Appends the boxes of a tile, in an order that does not depend on threads.
  void gather(std::size_t tile, std::vector<PackedBox>& boxes) const;
  bool covered(std::size_t tile) const { return covered_[tile]; }
  /// Ordinal of the tile's low corner.
  std::array<std::uint32_t, 3> corner(std::size_t tile) const;
  std::array<std::uint32_t, 3> edge(std::size_t tile) const;
  /// The least box that holds all boxes; lo > hi if there are none.
  const OrdinalBox& bounds() const { return bounds_; }

 private:
  /// Tiles from .. to by axis, counted from ordinal 0. Those beyond the region are not in the grid.
  struct TileRange {
    std::array<std::uint32_t, 3> from, to;
  };
  /// What one chunk of the input puts into a tile: blocks of words, all but the last one full.
  struct Share {
    std::uint64_t* last = nullptr;
    std::uint32_t count = 0;
  };
  /// Words of a tile that lie together in memory.
  using Piece = std::span<const std::uint64_t>;
  /// A word on its way into a tile. So many go at once that fetching the tiles' memory takes the time of one.
  struct Pending {
    std::uint64_t word;
    std::uint32_t tile;
  };
  static constexpr std::size_t kPending = 128;
  /// A range of the input, worked on by one thread, and what it puts into the tiles.
  struct Chunk {
    std::size_t begin = 0, end = 0;
    OrdinalBox bounds;
    std::vector<Share> shares;                                     // by tile
    std::vector<std::pair<std::uint64_t*, std::uint32_t>> blocks;  // and their tiles
    std::vector<Array<std::uint64_t>> slabs;                       // memory of the blocks
    std::size_t used = 0;                                          // words of the last slab
    double touched = 0, most_touched = 0;                          // tiles, by boxes that touch several
    std::array<Pending, kPending> pending;
    std::size_t pending_count = 0;
  };

  std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{z} * plan_.tiles[1] + y) * plan_.tiles[0] + x - first_index_;
  }
  std::array<std::uint32_t, 3> full_edge() const {
    return {1u << plan_.log_edge[0], 1u << plan_.log_edge[1], 1u << plan_.log_edge[2]};
  }
  TileRange touched(const OrdinalBox& box) const {
    TileRange range;
    for (int a = 0; a < 3; ++a) {
      range.from[a] = box.lo[a] >> plan_.log_edge[a];
      range.to[a] = box.hi[a] >> plan_.log_edge[a];
    }
    return range;
  }
  template <class F>
  void read(const OrdinalSource& source, const Chunk& chunk, F&& f) const;
  void put(Chunk& chunk, std::size_t tile, const PackedBox& box) const {
    __builtin_prefetch(&chunk.shares[tile], 1);
    words_.encode(box, [&](std::uint64_t word) {
      chunk.pending[chunk.pending_count++] = {word, std::uint32_t(tile)};
      if (chunk.pending_count == kPending) put_pending(chunk);
    });
  }
  void put_pending(Chunk& chunk) const;
  void scatter(const OrdinalSource& source, Chunk& chunk);
  void scatter_wide(const OrdinalBox& box, Chunk& chunk);
  void add_block(Chunk& chunk, std::size_t tile) const;
  void collect_pieces();

  Plan plan_;
  PackedWords words_;
  std::size_t first_index_ = 0;  // of the first tile, if tiles were counted from ordinal 0
  const std::atomic<bool>* interrupted_;
  std::vector<Chunk> chunks_;
  std::uint32_t block_ = 0;            // words of a block, a power of two
  std::vector<std::uint8_t> covered_;  // by tile
  std::vector<std::size_t> first_;     // piece of a tile
  std::vector<Piece> pieces_;          // by tile
  OrdinalBox bounds_;
  bool misjudged_ = false;
};

// ---- implementation ----

template <class F>
void OrdinalSource::read(std::size_t begin, std::size_t end, F&& f) const {
  const auto give = [&](const OrdinalBox& box) {
    if (box.lo[0] < box.hi[0] && box.lo[1] < box.hi[1] && box.lo[2] < box.hi[2]) f(box);
  };
  if (!boxes_) {
    for (std::size_t i = begin; i < end; ++i) give(kept_[i]);
    return;
  }
  const auto ordinal_box = [&](const auto& b) {
    OrdinalBox box;
    for (int a = 0; a < 3; ++a) {
      box.lo[a] = (*axes_)[a].ordinal(double(b[a]));
      box.hi[a] = (*axes_)[a].ordinal(double(b[a + 3]));
    }
    return box;
  };
  boxes_->visit([&]<class T>(const std::vector<BoxOf<T>>& boxes) {
    if constexpr (std::is_same_v<T, std::int32_t>) {
      std::array<int, 3> exponent;
      std::array<std::uint32_t, 3> base;  // modulo 2^32, which an ordinal fits
      for (int a = 0; a < 3; ++a) {
        exponent[a] = (*axes_)[a].exponent();
        base[a] = static_cast<std::uint32_t>((*axes_)[a].base());
      }
      const auto give_all = [&](auto&& shifted) {
        for (std::size_t i = begin; i < end; ++i) {
          OrdinalBox box;
          for (int a = 0; a < 3; ++a) {
            box.lo[a] = static_cast<std::uint32_t>(shifted(boxes[i][a], a)) - base[a];
            box.hi[a] = static_cast<std::uint32_t>(shifted(boxes[i][a + 3], a)) - base[a];
          }
          give(box);
        }
      };
      if (exponent == std::array{0, 0, 0})
        give_all([](T c, int) { return c; });
      else if (std::ranges::all_of(exponent, [](int e) { return e >= 0 && e < 32; }))
        give_all([&](T c, int a) { return c >> exponent[a]; });
      else  // finer or coarser than integers need: other boxes share the lattice
        for (std::size_t i = begin; i < end; ++i) give(ordinal_box(boxes[i]));
    } else {
      for (std::size_t i = begin; i < end; ++i) give(ordinal_box(boxes[i]));
    }
  });
}

}  // namespace boxunion

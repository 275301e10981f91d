#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/memory.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/cells/packed.hpp"

namespace boxunion {

/// Boxes in ordinals, from any origin: computed from a lattice on the fly, or kept in memory.
///
/// read(begin, end, f) calls f(box), in order, for those boxes of begin .. end - 1 that are not degenerate.
class OrdinalSource {
 public:
  /// Boxes on three lattices; `boxes` and `axes` must outlive the source.
  OrdinalSource(const BoxSet& boxes, const Axes& axes) : boxes_(&boxes), axes_(&axes), size_(boxes.size()) {}
  /// Boxes in memory; `kept` must outlive the source.
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
/// every tile that it touches. A tile covered by one box stores no boxes. The memory of a tile grows by
/// blocks, so the boxes are put in place in one pass, without counting them first.
class TileGrid {
 public:
  /// How the ordinals are cut. Tile i of an axis begins at ordinal (first + i) * 2^log_edge.
  struct Plan {
    std::array<int, 3> log_edge{};         ///< log2 of a tile's edge, at most 19
    std::array<std::uint32_t, 3> first{};  ///< by axis
    std::array<std::uint32_t, 3> tiles{};  ///< by axis
    std::array<std::uint32_t, 3> end{};    ///< end of the last tile, even if a whole tile would be longer
    double touched = 1;                    ///< average number of tiles that a box touches, by a sample
    double most_touched = 0;  ///< limit for all boxes of all sources together; beyond it the plan is wrong
    std::size_t count() const { return std::size_t{tiles[0]} * tiles[1] * tiles[2]; }
  };

  /// Chooses tiles for ordinals 1 .. counts[a]. There are so many tiles that the boxes of one stay in cache,
  /// with edges of at most 2^max_log_edge ordinals. For few boxes, there are enough tiles for several
  /// threads, if a tile still has `least` boxes. The plan is for the boxes of all sources; a grid may then be
  /// made for each source. Looks at `sample` boxes.
  static Plan plan(std::span<const OrdinalSource> sources, const std::array<std::uint32_t, 3>& counts,
                   int max_log_edge, std::size_t least, std::size_t sample = kSample);
  /// The same for only the points lo <= p < hi of a region. lo must be a multiple of 2^max_log_edge, and no
  /// box may reach beyond lo - 1 .. hi.
  static Plan plan(std::span<const OrdinalSource> sources, const OrdinalBox& region, int max_log_edge,
                   std::size_t least, std::size_t sample = kSample);
  static constexpr std::size_t kSample = 512;

  /// Puts the boxes of a source into tiles. Gives up if they touch more than plan.most_touched tiles; the
  /// grid is then useless. Throws Error(resources) if memory does not suffice.
  TileGrid(const OrdinalSource& source, const Plan& plan);

  /// True if it has given up. It then takes another plan, from a larger sample.
  bool misjudged() const { return misjudged_; }
  std::size_t size() const { return plan_.count(); }
  /// The number of words that the boxes of a tile take: at least the number of boxes, and up to twice that if
  /// they are not short.
  std::size_t words(std::size_t tile) const;
  /// Appends the boxes of a tile, in an order that does not depend on threads.
  void gather(std::size_t tile, std::vector<PackedBox>& boxes) const;
  bool covered(std::size_t tile) const { return covered_[tile]; }
  /// The ordinals of the tile's low corner.
  std::array<std::uint32_t, 3> corner(std::size_t tile) const;
  std::array<std::uint32_t, 3> edge(std::size_t tile) const;
  /// The bounding box of all boxes; lo > hi if there are none.
  const OrdinalBox& bounds() const { return bounds_; }

 private:
  /// Tiles from .. to on each axis, counted from ordinal 0. Tiles beyond the region are not in the grid.
  struct TileRange {
    std::array<std::uint32_t, 3> from, to;
  };
  /// The words that one chunk of the input puts into a tile: blocks, all but the last one full.
  struct Share {
    std::uint64_t* last = nullptr;
    std::uint32_t count = 0;
  };
  /// Words of a tile that are contiguous in memory.
  using Piece = std::span<const std::uint64_t>;
  /// A word on its way into a tile. So many are written at once that fetching the memory of all tiles takes
  /// the time of one.
  struct Pending {
    std::uint64_t word;
    std::uint32_t tile;
  };
  static constexpr std::size_t kPending = 128;
  /// A range of the input that one thread processes, and the words that it puts into the tiles.
  struct Chunk {
    std::size_t begin = 0, end = 0;
    OrdinalBox bounds;
    std::vector<Share> shares;                                     // by tile
    std::vector<std::pair<std::uint64_t*, std::uint32_t>> blocks;  // with their tiles
    std::vector<Array<std::uint64_t>> pools;                       // memory of the blocks
    std::size_t used = 0;                                          // words used in the last pool
    double touched = 0, most_touched = 0;  // tiles touched by boxes that touch several
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
  std::size_t first_index_ = 0;  // of the first tile, counted from ordinal 0
  std::vector<Chunk> chunks_;
  std::uint32_t block_ = 0;            // words of a block, a power of two
  std::vector<std::uint8_t> covered_;  // by tile
  std::vector<std::size_t> first_;     // by tile: its first piece
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
      std::array<std::uint32_t, 3> base;  // modulo 2^32, which is enough for ordinals
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
      else  // other boxes share the lattice and make it finer or coarser
        for (std::size_t i = begin; i < end; ++i) give(ordinal_box(boxes[i]));
    } else {
      for (std::size_t i = begin; i < end; ++i) give(ordinal_box(boxes[i]));
    }
  });
}

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/axis.hpp"
#include "core/packed.hpp"

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

/// The boxes of a run, sorted into the tiles of a uniform grid, packed for the kernels. A box is in every
/// tile that it touches; a tile that one box covers holds none.
class TileGrid {
 public:
  /// How the ordinals are cut; tile i of an axis begins at ordinal i * 2^log_edge.
  struct Plan {
    std::array<int, 3> log_edge{};         ///< log2 of a tile's edge, at most 19
    std::array<std::uint32_t, 3> tiles{};  ///< by axis
    double touched = 1;                    ///< tiles that a box touches, on average, by a sample
    std::size_t count() const { return std::size_t{tiles[0]} * tiles[1] * tiles[2]; }
  };

  /// Chooses tiles for ordinals 1 .. counts[a]: as many as keep a tile's boxes in cache, with edges of at
  /// most 2^max_log_edge ordinals.
  static Plan plan(const OrdinalSource& source, const std::array<std::uint32_t, 3>& counts, int max_log_edge);

  TileGrid(const OrdinalSource& source, const Plan& plan);

  std::size_t size() const { return plan_.count(); }
  std::span<const PackedBox> boxes(std::size_t tile) const {
    return {boxes_.get() + first_[tile], first_[tile + 1] - first_[tile]};
  }
  bool covered(std::size_t tile) const { return !covered_.empty() && covered_[tile]; }
  /// Ordinal of the tile's low corner.
  std::array<std::uint32_t, 3> corner(std::size_t tile) const;
  std::array<std::uint32_t, 3> edge() const;
  /// Boxes over all tiles (a box counts in each that it touches).
  std::size_t items() const { return first_.back(); }
  /// The least box that holds all boxes; lo > hi if there are none.
  const OrdinalBox& bounds() const { return bounds_; }

 private:
  Plan plan_;
  std::vector<std::size_t> first_;  // by tile, and the end
  std::vector<std::uint8_t> covered_;
  std::unique_ptr<PackedBox, void (*)(void*)> boxes_;
  OrdinalBox bounds_;
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
  boxes_->visit([&]<class T>(const std::vector<BoxOf<T>>& boxes) {
    if constexpr (std::is_same_v<T, std::int32_t>) {
      std::array<int, 3> shift;
      std::array<std::int64_t, 3> base;
      for (int a = 0; a < 3; ++a) shift[a] = (*axes_)[a].exponent(), base[a] = (*axes_)[a].base();
      for (std::size_t i = begin; i < end; ++i) {
        const BoxOf<T>& b = boxes[i];
        OrdinalBox box;
        for (int a = 0; a < 3; ++a) {
          box.lo[a] = static_cast<std::uint32_t>((b[a] >> shift[a]) - base[a]);
          box.hi[a] = static_cast<std::uint32_t>((b[a + 3] >> shift[a]) - base[a]);
        }
        give(box);
      }
    } else {
      for (std::size_t i = begin; i < end; ++i) {
        const BoxOf<T>& b = boxes[i];
        OrdinalBox box;
        for (int a = 0; a < 3; ++a) {
          box.lo[a] = (*axes_)[a].ordinal(b[a]);
          box.hi[a] = (*axes_)[a].ordinal(b[a + 3]);
        }
        give(box);
      }
    }
  });
}

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/boxes/ordinals.hpp"

namespace boxunion {

/// A rectangle of a slab, or a tile of its plane: x_lo, y_lo, x_hi, y_hi.
using SlabRectangle = std::array<std::uint32_t, 4>;

/// Some neighboring slabs with their rectangles.
struct SlabBatch {
  std::uint32_t first = 0;           ///< first slab
  std::vector<std::size_t> offsets;  ///< slab first + i has rectangles [offsets[i], offsets[i + 1])
  std::vector<SlabRectangle> rectangles;

  std::uint32_t slabs() const { return offsets.empty() ? 0 : std::uint32_t(offsets.size() - 1); }
};

/// Sweeps a plane along z through a set of boxes (López Monterde et al., section 6). Slab i lies between the
/// distinct z ordinals i and i + 1, and its rectangles are the boxes that cross it. Slabs come in batches, so
/// memory is bounded by the boxes and one batch.
///
/// In slabs, x is the position among the distinct x ordinals of the boxes, so that sets of x are small
/// bitmaps.
class SlabSweep {
 public:
  explicit SlabSweep(std::vector<OrdinalBox> boxes);

  std::uint32_t slabs() const { return z_.empty() ? 0 : std::uint32_t(z_.size() - 1); }
  /// Ordinal of the plane below slab i (i = slabs(): the plane above the last one).
  std::uint32_t z(std::uint32_t i) const { return z_[i]; }
  const std::vector<std::uint32_t>& x() const { return x_; }

  /// Gets the next slabs: as many as have at most `limit` rectangles together, but at least one. False at the
  /// end.
  bool next(std::size_t limit, SlabBatch& batch);

 private:
  std::vector<OrdinalBox> boxes_;          // by lower z; x and z are positions in x_ and z_
  std::vector<std::uint32_t> x_, z_;       // sorted distinct ordinals
  std::vector<std::uint32_t> rectangles_;  // by slab: the number of boxes that cross it
  std::vector<std::uint32_t> active_;      // boxes that may reach the next batch
  std::size_t next_box_ = 0;
  std::uint32_t next_slab_ = 0;
};

/// Tiles of one or more slabs with their rectangles, as the kernel `contour` reads them.
struct Tiles {
  struct Tile {
    SlabRectangle region;  ///< owns the points with lo <= p < hi
    std::uint32_t first = 0, count = 0;
  };
  std::vector<Tile> tiles;
  std::vector<SlabRectangle> rectangles;
};

/// Cuts the plane of a slab into tiles that a kernel can hold (at most 31 distinct coordinates on each axis)
/// and appends them to `out`. One tile owns each contour vertex of the slab. A tile covered by one rectangle
/// has no vertex and is left out. Near-linear: a tile is halved at the median of its own coordinates.
void cut_tiles(std::span<const SlabRectangle> slab, std::uint32_t max_coordinates, Tiles& out);

}  // namespace boxunion

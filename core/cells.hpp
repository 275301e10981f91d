#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mass.hpp"
#include "core/packed.hpp"

namespace boxunion {

/// A cell as the kernels read it: its region and its boxes.
struct Cell {
  std::uint64_t origin = 0;            ///< region.lo - 1, packed
  std::uint64_t last = 0;              ///< region.hi - region.lo + 1, packed
  std::uint32_t first = 0, count = 0;  ///< in CellBatch::items
};

/// Neighbouring cells of one tile, the work unit of a kernel. The ordinal of packed coordinate c is origin +
/// c.
struct CellRun {
  std::uint32_t first = 0, count = 0;
  std::array<std::uint32_t, 3> origin{};
};

/// Cells of one or more tiles with their boxes, ready for a kernel.
struct CellBatch {
  std::vector<PackedBox> boxes;
  std::vector<std::uint32_t> items;  ///< boxes of the cells, by index
  std::vector<Cell> cells;
  std::vector<CellRun> runs;

  void clear();
};

/// What the grid did with the boxes of a run (UNION3, table 1).
struct CellStatistics {
  std::uint64_t cells = 0;          ///< cells with boxes that a kernel looked at
  std::uint64_t covered_cells = 0;  ///< cells (or larger regions) that one box covers
  std::uint64_t items = 0;          ///< cell-box overlaps
  CellStatistics& operator+=(const CellStatistics& other);
};

/// Cuts tiles into cells that a kernel can hold: at most 31 distinct coordinates of its own on every axis.
///
/// A uniform grid (UNION3, section 4) whose cell size fits the tile's boxes does most of the work while they
/// are in cache; cells that one box covers are marked before anything is stored in them; cells that are still
/// crowded are halved at the median of their coordinates until they fit, equal clips merged on the way.
class TileCutter {
 public:
  struct Tuning {
    std::uint32_t cell = 0;  ///< edge of a cell in ordinals, rounded up to a power of two; 0: by estimate
    std::uint32_t cell_boxes = 0;  ///< boxes of a cell above which it is halved; 0: what proved fastest
  };
  explicit TileCutter(Tuning tuning) : tuning_(tuning) {}

  /// Appends the cells of a tile to `batch` as runs of at most `cells_per_run` cells. `size` is the tile's
  /// edge by axis, at most 2^19; `origin` the ordinal of packed coordinate 0. If `covered` is given, volume
  /// and moments of the covered regions are added to it, in coordinates that count from 0 at the low corner.
  void cut(std::span<const PackedBox> boxes, const std::array<std::uint32_t, 3>& size,
           const std::array<std::uint32_t, 3>& origin, std::uint32_t cells_per_run, CellBatch& batch,
           LatticeSums* covered);

  const CellStatistics& statistics() const { return statistics_; }

 private:
  void choose_cell_size();
  void cut_grid();
  void cut_cell(const PackedRegion& region, std::size_t begin);
  void find_own_coordinates(const PackedRegion& region, std::size_t begin);
  void merge_equal_clips(const PackedRegion& region, std::size_t begin);
  void add_cell(const PackedRegion& region, std::span<const std::uint32_t> items);
  void add_covered(const PackedRegion& region);

  Tuning tuning_;
  CellStatistics statistics_;

  // the tile at work
  std::span<const PackedBox> boxes_;
  std::array<std::uint32_t, 3> size_{};
  std::array<int, 3> cell_log_{};  // log2 of the cell's edge by axis
  std::uint32_t first_box_ = 0;    // of the tile, in the batch
  CellBatch* batch_ = nullptr;
  LatticeSums* covered_ = nullptr;

  // scratch
  std::vector<std::uint32_t> start_;  // by cell: end of its items, then start
  std::vector<std::uint8_t> covered_cell_;
  std::vector<std::array<std::uint32_t, 2>> pairs_;  // cell, box
  std::vector<std::uint32_t> sorted_;                // boxes by cell
  std::vector<std::uint32_t> stack_;                 // boxes of the cells being halved
  std::array<std::vector<std::uint32_t>, 3> own_;    // coordinates of the cell being halved
};

}  // namespace boxunion

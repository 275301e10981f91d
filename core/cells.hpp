#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "core/clusters.hpp"
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
  /// Adds another batch's cells behind this one's.
  void append(const CellBatch& other);
};

/// What the grid did with the boxes of a run (UNION3, table 1).
struct CellStatistics {
  std::uint64_t cells = 0;          ///< cells with boxes that a kernel looked at
  std::uint64_t covered_cells = 0;  ///< cells (or larger regions) that one box covers
  std::uint64_t items = 0;          ///< cell-box overlaps
  CellStatistics& operator+=(const CellStatistics& other);
};

/// Cuts tiles into cells that a kernel can hold: at most 30 distinct coordinates of its own on every axis.
///
/// Small clusters of boxes that touch no others get a cell each; what is left, or where nearly all boxes
/// touch others, all of them, is cut by a grid. A uniform grid (UNION3, section 4) whose cell size fits the
/// boxes does most of the work while they are in cache; cells that one box covers are marked before anything
/// is stored in them; a cell that is still crowded gets a grid of its own or, with few boxes, is halved at
/// the median of its coordinates until it fits. Equal clips are merged on the way.
class TileCutter {
 public:
  struct Tuning {
    std::uint32_t cell = 0;  ///< edge of a cell in ordinals, rounded up to a power of two; 0: by estimate
    std::uint32_t cell_boxes = 0;  ///< boxes of a cell above which it is cut again; 0: what proved fastest
    const std::atomic<bool>* interrupted =
        nullptr;  ///< where it becomes true, cut() throws Error(interrupted)
  };
  explicit TileCutter(Tuning tuning);

  /// Appends the cells of a tile to `batch` as runs whose boxes, squared by cell, add up to about `run_cost`.
  /// `edge` is the tile's by axis, at most 2^19; `origin` the ordinal of packed coordinate 0. If `sums` are
  /// given, what has a closed form is added to them and not to the batch: covered regions, lone boxes and
  /// pairs, in coordinates that count from 0 at the low corner.
  void cut(std::span<const PackedBox> boxes, const std::array<std::uint32_t, 3>& edge,
           const std::array<std::uint32_t, 3>& origin, std::uint64_t run_cost, CellBatch& batch,
           LatticeSums* sums);

  /// Notes a tile that one box covers, as cut() does with covered cells.
  void add_covered_tile(const std::array<std::uint32_t, 3>& edge, LatticeSums* sums);

  const CellStatistics& statistics() const { return statistics_; }

 private:
  using Items = std::span<const std::uint32_t>;  // boxes of the tile, by index
  /// A grid over a region.
  struct Grid {
    PackedRegion region;
    std::array<int, 3> log_edge{};  // log2 of the cell's edge
    std::array<std::uint32_t, 3> cells{};
    std::size_t count() const { return std::size_t{cells[0]} * cells[1] * cells[2]; }
    PackedRegion cell(std::uint32_t x, std::uint32_t y, std::uint32_t z) const;
  };
  /// Memory of one level of grids.
  struct Level {
    std::vector<std::uint32_t> start;                 // of each cell's boxes
    std::vector<std::uint8_t> covered;                // by cell
    std::vector<std::array<std::uint32_t, 2>> pairs;  // cell, box
    std::vector<std::uint32_t> sorted;                // boxes by cell
    std::vector<std::uint32_t> kept;                  // boxes that are not hidden
  };

  Items first_indices(std::size_t count);
  void cut_clusters(const PackedRegion& tile);
  PackedRegion bounding_region(const PackedRegion& tile, Items items) const;
  Items drop_hidden(const PackedRegion& region, Items items, std::vector<std::uint32_t>& kept) const;
  Grid choose_grid(const PackedRegion& region, Items items, bool fixed) const;
  void cut_by_grid(const Grid& grid, Items items, std::size_t depth);
  bool mark_covered(const Grid& grid, Items items, Level& level) const;
  void sort_by_cell(const Grid& grid, Items items, bool any_covered, Level& level) const;
  void cut_region(const PackedRegion& region, Items items, std::size_t depth);
  void halve(const PackedRegion& region, std::size_t begin);
  void find_own_coordinates(const PackedRegion& region, Items items);
  void merge_equal_clips(const PackedRegion& region, std::vector<std::uint32_t>& items,
                         std::size_t begin) const;
  void add_cell(const PackedRegion& region, Items items);
  void add_covered(const PackedRegion& region);

  Tuning tuning_;
  CellStatistics statistics_;

  // the tile at work
  std::span<const PackedBox> boxes_;
  std::uint32_t first_box_ = 0;  // of the tile, in the batch
  CellBatch* batch_ = nullptr;
  LatticeSums* sums_ = nullptr;

  // scratch
  Clusters clusters_;
  std::vector<std::uint32_t> all_;  // 0, 1, 2, ...
  std::vector<Level> levels_;
  std::vector<std::uint32_t> stack_;               // boxes of the cells being halved
  std::array<std::vector<std::uint32_t>, 3> own_;  // distinct coordinates of a region, sorted
};

}  // namespace boxunion

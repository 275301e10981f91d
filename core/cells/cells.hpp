#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "boxunion/statistics.hpp"
#include "core/cells/cell_program.hpp"
#include "core/cells/clusters.hpp"
#include "core/cells/expression.hpp"
#include "core/cells/packed.hpp"
#include "core/solid/mass_sink.hpp"

namespace boxunion {

/// A cell in the form that kernels read: its region and its boxes.
struct Cell {
  std::uint64_t origin = 0;  ///< region.lo - 1, packed
  std::uint64_t last = 0;    ///< region.hi - region.lo + 1, packed; for sums, with the guard bits of axes on
                             ///< which the region ends with its tile
  std::uint32_t first = 0, count = 0;  ///< in CellBatch::items
};

/// Neighboring cells of one tile: the work unit of a kernel. The ordinal of packed coordinate c is origin +
/// c.
struct CellRun {
  std::uint32_t first = 0, count = 0;
  std::array<std::uint32_t, 3> origin{};
};

/// The runs of one tile: those up to `end_run`. The tile's sums are its runs' plus the closed-form part; only
/// together are they the sums of a region.
struct TileRuns {
  std::size_t end_run = 0;
  std::array<std::uint32_t, 3> corner{};  ///< the origin of the sums, in ordinals
  LatticeSums closed;
};

/// Cells of one or more tiles with their boxes, ready for a kernel.
struct CellBatch {
  std::vector<PackedBox> boxes;
  std::vector<std::uint32_t> items;  ///< boxes of the cells, by index
  std::vector<Cell> cells;
  std::vector<CellRun> runs;
  std::vector<TileRuns> tiles;        ///< those that have runs
  std::vector<CellProgram> programs;  ///< by cell; empty if all are unions
  std::vector<CellStep> steps;

  void clear();
  /// Appends the cells of another batch.
  void append(const CellBatch& other);
};

/// The bounds of the result of an expression in a tile, in packed coordinates; lo > hi if it is empty.
struct Reach {
  std::array<std::uint32_t, 3> lo{packed::kMax, packed::kMax, packed::kMax}, hi{};

  bool empty() const { return lo[0] > hi[0]; }
  /// Adds the part of a box in a region.
  void extend(const PackedBox& box, const PackedRegion& region);
};

/// The boxes of a tile. If there are several operands, the boxes are sorted by operand, and `operands` has
/// that of each box.
struct TileBoxes {
  std::span<const PackedBox> boxes;
  std::span<const std::uint32_t> operands;
};

/// Cuts tiles into cells that a kernel can hold: at most 30 distinct coordinates of its own on every axis.
///
/// Small clusters of boxes that touch no others get a cell each. A grid cuts the rest, or all boxes if nearly
/// all touch others. A uniform grid (UNION3, section 4), whose cell size fits the boxes, does most of the
/// work while they are in cache. Cells covered by one box are marked before anything is stored in them. A
/// cell that is still crowded gets a grid of its own. With few boxes, it is halved at the median of its
/// coordinates until it fits. Equal clips are merged on the way.
///
/// A tile may hold an expression over several operands. The expression is simplified in each region on the
/// way down. An operand without boxes there is false, an operand with a box that covers the region is true,
/// and the boxes of operands that no longer matter are dropped. If the union of some operands is left, the
/// region goes on like any other union.
class TileCutter {
 public:
  struct Tuning {
    std::uint32_t cell = 0;  ///< edge of a cell in ordinals, rounded up to a power of two; 0: by estimate
    std::uint32_t cell_boxes = 0;  ///< a cell with more boxes is cut again; 0: the fastest value
  };
  /// `operands` is the number of operands of the expressions, or 0 if all tiles are unions.
  explicit TileCutter(Tuning tuning, std::size_t operands = 0);

  /// Appends the cells of a tile to `batch`, in runs. The squares of the numbers of boxes of a run's cells
  /// add up to about `run_cost`. `edge` is the edge of the tile on each axis, at most 2^19. `origin` has the
  /// ordinals of packed coordinate 0. If `sums` are given, parts with a closed form are added to them instead
  /// of the batch: covered regions, lone boxes and pairs, in coordinates that count from 0 at the low corner.
  /// `steps` is the expression of the tile; without steps, it is the union of the boxes.
  void cut(const TileBoxes& boxes, std::span<const Step> steps, const std::array<std::uint32_t, 3>& edge,
           const std::array<std::uint32_t, 3>& origin, std::uint64_t run_cost, CellBatch& batch,
           LatticeSums* sums);

  /// Counts a tile covered by one box, as cut() does with covered cells.
  void add_covered_tile(const std::array<std::uint32_t, 3>& edge, LatticeSums* sums);

  const CellStatistics& statistics() const { return statistics_; }

  /// With operands: the reach of what the last tile added to the sums, and of all its cells without a
  /// program.
  const Reach& reach() const { return reach_; }

 private:
  using Items = std::span<const std::uint32_t>;  // boxes of the tile, by index, sorted by operand
  using Steps = std::span<const Step>;           // empty: the union of the boxes
  /// A grid over a region.
  struct Grid {
    PackedRegion region;
    std::array<int, 3> log_edge{};  // log2 of the cell's edge
    std::array<std::uint32_t, 3> cells{};
    std::size_t most_items = 0;  // maximum sum, over all boxes, of the cells touched
    std::size_t count() const { return std::size_t{cells[0]} * cells[1] * cells[2]; }
    PackedRegion cell(std::uint32_t x, std::uint32_t y, std::uint32_t z) const;
  };
  /// Memory for one level of grids.
  struct Level {
    std::vector<std::uint32_t> start;                 // first box of each cell
    std::vector<std::uint8_t> covered;                // by cell
    std::vector<std::array<std::uint32_t, 2>> pairs;  // cell, box
    std::vector<std::uint32_t> sorted;                // boxes by cell
    std::vector<std::uint32_t> kept;                  // boxes that are not hidden
    std::vector<std::uint32_t> relevant;              // boxes of operands that matter
    std::vector<std::uint32_t> visible;               // boxes of each operand that are not hidden
    std::vector<Step> steps;                          // the remaining expression
  };

  Items first_indices(std::size_t count);
  void cut_clusters(const PackedRegion& tile);
  void cut_clusters(const PackedRegion& tile, Steps steps);
  bool is_empty_without_boxes(Steps steps);
  Filling reduce(const PackedRegion& region, Items& items, Steps& steps, Level& level);
  template <class F>
  void each_operand(Items items, F&& f) const;
  PackedRegion bounding_region(const PackedRegion& tile, Items items) const;
  Items drop_hidden(const PackedRegion& region, Items items, std::vector<std::uint32_t>& kept) const;
  Items drop_hidden_by_operand(const PackedRegion& region, Items items, Level& level) const;
  Grid choose_grid(const PackedRegion& region, Items items, bool fixed) const;
  bool may_have_vertices(const PackedRegion& region, Items items) const;
  bool cut_by_grid(const Grid& grid, Items items, Steps steps, std::size_t depth);
  bool mark_covered(const Grid& grid, Items items, Level& level) const;
  bool sort_by_cell(const Grid& grid, Items items, Level& level) const;
  void cut_region(const PackedRegion& region, Items items, Steps steps, std::size_t depth);
  void halve(const PackedRegion& region, std::size_t begin, Steps steps, std::size_t depth);
  void halve_expression(const PackedRegion& half, std::size_t begin, Steps steps, std::size_t depth);
  void find_own_coordinates(const PackedRegion& region, Items items);
  void merge(const PackedRegion& region, std::size_t begin, Steps steps);
  std::size_t merge_equal_clips(const PackedRegion& region, std::span<std::uint32_t> items) const;
  void add_cell(const PackedRegion& region, Items items, Steps steps = {});
  void add_program(const PackedRegion& region, Items items, Steps steps);
  void add_covered(const PackedRegion& region);
  void sort_by_count(std::size_t first);
  void add_runs(std::size_t first, const std::array<std::uint32_t, 3>& origin, std::uint64_t run_cost);
  bool has_operands() const { return !presence_.empty(); }

  Tuning tuning_;
  CellStatistics statistics_;

  // the current tile
  std::span<const PackedBox> boxes_;
  std::span<const std::uint32_t> operands_;  // of the boxes
  std::uint64_t tile_end_ = 0;               // upper corner of the tile
  std::uint32_t first_box_ = 0;              // of the tile, in the batch
  CellBatch* batch_ = nullptr;
  LatticeSums* sums_ = nullptr;
  Reach reach_;

  // scratch
  Clusters clusters_;
  std::vector<std::uint32_t> all_;  // 0, 1, 2, ...
  std::vector<Level> levels_;
  std::deque<Level> halvings_;         // by depth: relevant boxes and steps only
  std::vector<Presence> presence_;     // by operand
  std::vector<CellBoxes> cell_boxes_;  // by operand
  Level cluster_;
  std::vector<std::uint32_t> stack_;  // boxes of the cells being halved
  std::vector<Cell> unsorted_;
  std::array<std::vector<std::uint32_t>, 3> own_;  // coordinates that a region owns
};

}  // namespace boxunion

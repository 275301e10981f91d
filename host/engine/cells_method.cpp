#include "host/engine/cells_method.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <mutex>
#include <optional>

#include "boxunion/error.hpp"
#include "core/base/parallel.hpp"
#include "core/cells/cells.hpp"
#include "core/cells/tiles.hpp"
#include "host/engine/cell_stage.hpp"
#include "host/engine/resilient.hpp"
#include "host/engine/stopwatch.hpp"

namespace boxunion {
namespace {

constexpr int kSumsLogEdge = std::countr_zero(LatticeSums::kMostEdge);
constexpr int kPackedLogEdge = packed::kBits - 1;   // what a packed coordinate holds
constexpr std::uint64_t kRunCost = 1024;            // of a work unit on a device; see TileCutter::cut
constexpr std::uint64_t kNativeRunCost = 1u << 20;  // the same natively: some milliseconds
// Minimum boxes in a tile if there are few boxes. A device needs more, because lavapipe stops the loops of
// larger cells.
constexpr std::size_t kLeastInTile = 1000, kLeastInNativeTile = 250;
constexpr std::size_t kMostAtOnce = 1u << 16;  // if all tiles have fewer boxes, they are cut first

/// Replaces ordinals by their positions (from 1) among those that occur, and maps them back. For axes so wide
/// that a grid over them would be nearly empty.
class Positions {
 public:
  Positions(std::vector<OrdinalBox>& boxes, const std::array<bool, 3>& axes) {
    for (int a = 0; a < 3; ++a) {
      if (!axes[a]) continue;
      ordinals_[a] = distinct_ordinals(boxes, a);
      replace_by_positions(boxes, a, ordinals_[a], 1);
    }
  }

  std::uint32_t count(int axis) const { return std::uint32_t(ordinals_[axis].size()); }
  void map_back(std::span<Vertex> vertices) const {
    for (Vertex& v : vertices) {
      if (!ordinals_[0].empty()) v.x = ordinals_[0][v.x - 1];
      if (!ordinals_[1].empty()) v.y = ordinals_[1][v.y - 1];
      if (!ordinals_[2].empty()) v.z = ordinals_[2][v.z - 1];
    }
  }

 private:
  std::array<std::vector<std::uint32_t>, 3> ordinals_;
};

/// Passes vertices on with ordinals instead of positions.
class PositionSink : public VertexSink {
 public:
  PositionSink(const Positions& positions, VertexSink& sink) : positions_(positions), sink_(sink) {}
  void add(std::span<const Vertex> vertices) override {
    std::vector<Vertex> mapped(vertices.begin(), vertices.end());
    positions_.map_back(mapped);
    sink_.add(mapped);
  }

 private:
  const Positions& positions_;
  VertexSink& sink_;
};

/// One run of the method over a grid of tiles that all operands of an expression share.
class CellRunner {
 public:
  CellRunner(std::span<const TileGrid> grids, std::span<const Step> expression, const Options& options,
             const CellSink& sink, Report& report)
      : grids_(grids),
        expression_(expression),
        options_(options),
        sink_(sink),
        report_(report),
        cutters_([this] {
          const std::size_t operands = sink_.programs ? grids_.size() : 0;
          return Cutter{TileCutter({options_.tuning.cell, options_.tuning.cell_boxes}, operands),
                        std::vector<Presence>(grids_.size()),
                        {},
                        {},
                        {}};
        }) {}

  /// All cells in one batch, cut as for a device.
  CellBatch cut_all() {
    CellBatch batch;
    std::size_t tile = 0;
    fill(batch, std::numeric_limits<std::size_t>::max(), tile);
    return batch;
  }

  void run(Device& device) {
    report_.device = device.info().id;
    std::size_t tile = 0;
    if (report_.device != "native") {
      try {
        CellStage stages[2] = {{device, options_, sink_}, {device, options_, sink_}};
        run_on_device(stages, tile);
      } catch (const Error& error) {
        fall_back(error, report_.device, options_);
        report_.device = "native";
        NativeCells native(options_.kernel, sink_);
        for (CellBatch& batch : batches_) {  // batches that the device had not returned
          native.run(batch);
          batch.clear();
        }
      }
    }
    run_natively(tile);
    cutters_.for_each([&](const Cutter& c) { report_.cells += c.cutter.statistics(); });
  }

 private:
  struct Cutter {
    TileCutter cutter;
    // of the current tile
    std::vector<Presence> presence;
    std::vector<Step> steps;
    std::vector<PackedBox> boxes;
    std::vector<std::uint32_t> operands;  // operand of each box
  };

  /// Cuts a tile and appends its cells to `batch`.
  void cut(std::size_t tile, std::uint64_t run_cost, CellBatch& batch) {
    const auto corner = grids_[0].corner(tile), edge = grids_[0].edge(tile);
    const std::array<std::uint32_t, 3> origin{corner[0] - 1, corner[1] - 1, corner[2] - 1};
    LatticeSums sums;
    const std::size_t first_run = batch.runs.size();
    Cutter& mine = cutters_.local();
    for (std::size_t i = 0; i < grids_.size(); ++i)
      mine.presence[i] = grids_[i].covered(tile)     ? Presence::all
                         : grids_[i].words(tile) > 0 ? Presence::partial
                                                     : Presence::absent;
    const Filling filling = simplify(expression_, mine.presence, mine.steps);
    if (filling == Filling::everything) {
      mine.cutter.add_covered_tile(edge, sink_.sums ? &sums : nullptr);
    } else if (filling == Filling::varies) {
      gather(tile, mine);
      const bool is_union = boxunion::is_union(mine.steps);
      mine.cutter.cut({mine.boxes, mine.operands}, is_union ? std::span<const Step>() : mine.steps, edge,
                      origin, run_cost, batch, sink_.sums ? &sums : nullptr);
    }
    if (batch.runs.size() > first_run)
      batch.tiles.push_back({batch.runs.size(), corner, sums});
    else if (sums != LatticeSums{})
      sink_.sums->add(sums, corner);
    if (sink_.sums && sink_.programs && filling != Filling::nothing)
      extend_bounds(*sink_.sums, mine.cutter.reach(), origin);
    const std::size_t done = ++done_;
    if (options_.progress && done % 16 == 0) options_.progress(double(done) / double(tiles()));
  }

  /// Gathers the boxes of a tile that belong to operands that matter.
  void gather(std::size_t tile, Cutter& mine) const {
    std::ranges::fill(mine.presence, Presence::absent);
    for (const Step step : mine.steps)
      if (step.kind == Step::Kind::operand) mine.presence[step.operand] = Presence::partial;
    mine.boxes.clear();
    mine.operands.clear();
    for (std::size_t i = 0; i < grids_.size(); ++i) {
      if (mine.presence[i] == Presence::absent) continue;
      grids_[i].gather(tile, mine.boxes);
      if (sink_.programs) mine.operands.resize(mine.boxes.size(), std::uint32_t(i));
    }
  }

  std::size_t tiles() const { return grids_[0].size(); }
  /// An upper bound of the number of boxes in a tile, at most twice that number.
  std::size_t count(std::size_t tile) const {
    std::size_t sum = 0;
    for (const TileGrid& grid : grids_) sum += grid.words(tile);
    return sum;
  }

  /// True if a few tiles hold most of the boxes, so that threads cannot share the tiles.
  bool is_uneven(std::size_t first_tile) const {
    std::size_t boxes = 0, most = 0;
    for (std::size_t tile = first_tile; tile < tiles() && boxes <= kMostAtOnce; ++tile) {
      const std::size_t here = count(tile);
      boxes += here;
      most = std::max(most, here);
    }
    return thread_count() > 1 && boxes <= kMostAtOnce && most * (thread_count() + 1) > boxes;
  }

  /// Each thread cuts a tile and computes its cells while they are in its cache. If the tiles are uneven,
  /// they are cut first, and threads share the cells.
  void run_natively(std::size_t first_tile) {
    if (is_uneven(first_tile)) {
      CellBatch batch;
      fill(batch, std::numeric_limits<std::size_t>::max(), first_tile);
      return NativeCells(options_.kernel, sink_).run(batch);
    }
    struct Worker {
      NativeCells cells;
      CellBatch batch;
    };
    PerThread<Worker> workers([&] { return Worker{NativeCells(options_.kernel, sink_), {}}; });
    parallel_ranges(first_tile, tiles(), 1, [&](std::size_t begin, std::size_t end) {
      Worker& worker = workers.local();
      for (std::size_t tile = begin; tile < end; ++tile) {
        worker.batch.clear();
        cut(tile, kNativeRunCost, worker.batch);
        worker.cells.run(worker.batch);
      }
    });
  }

  /// The host cuts a batch of tiles while the device computes the one before. `tile` is the first tile that
  /// is not yet in a batch.
  void run_on_device(CellStage (&stages)[2], std::size_t& tile) {
    const std::size_t capacity = stages[0].capacity(expression_.size());
    for (int current = 0;; current = 1 - current) {
      CellBatch& batch = batches_[current];
      fill(batch, capacity, tile);
      if (!batch.runs.empty()) stages[current].begin(batch);
      CellBatch& previous = batches_[1 - current];
      if (!previous.runs.empty()) {
        stages[1 - current].finish(previous);
        previous.clear();
      }
      if (batch.runs.empty() && tile == tiles()) return;
    }
  }

  /// Cuts tiles until the batch holds about `capacity` boxes.
  void fill(CellBatch& batch, std::size_t capacity, std::size_t& tile) {
    batch.clear();
    std::size_t end = tile, boxes = 0;
    while (end < tiles() && (boxes == 0 || boxes + count(end) <= capacity / 4)) boxes += count(end++);
    std::mutex mutex;
    parallel_ranges(tile, end, 1, [&](std::size_t first, std::size_t last) {
      CellBatch& part = parts_.local();
      part.clear();
      for (std::size_t t = first; t < last; ++t) cut(t, kRunCost, part);
      const std::lock_guard lock(mutex);
      batch.append(part);
    });
    tile = end;
  }

  std::span<const TileGrid> grids_;
  std::span<const Step> expression_;
  const Options& options_;
  const CellSink& sink_;
  Report& report_;
  PerThread<Cutter> cutters_;
  PerThread<CellBatch> parts_;  // of the current batch
  CellBatch batches_[2];
  std::atomic<std::size_t> done_ = 0;
};

/// True if a grid of tiles for sums can begin where the region does.
bool can_be_tiled(const OrdinalBox& region) {
  return std::ranges::all_of(region.lo, [](std::uint32_t lo) { return lo % (1u << kRegionLogEdge) == 0; });
}

constexpr double kMostTouchedInRegion = 8;  // kMostTouched if other regions may be summed already

/// The boxes of combine_by_cells in ordinals, and their tiles.
class TiledBoxes {
 public:
  /// The boxes are `ordinals.boxes`. If these have no ends, they are those of `sets` on the axes, which must
  /// then be lattices. Sums over tiles without vertices are found only if `sums` is true.
  TiledBoxes(std::span<const BoxSet> sets, Ordinals& ordinals, const Options& options,
             std::size_t least_in_tile, bool sums)
      : sets_(sets), ordinals_(ordinals), options_(options), least_in_tile_(least_in_tile), sums_(sums) {
    if (ordinals.ends.empty()) {
      for (const BoxSet& set : sets) {
        sources_.emplace_back(set, ordinals.axes);
        boxes_ += set.size();
      }
    } else {
      use_kept();
    }
    for (int a = 0; a < 3; ++a) counts_[a] = ordinals.axes[a].count();
  }

  /// Chooses tiles and puts the boxes into them. If the boxes touch far more tiles than the sample suggested,
  /// plans again with a larger sample.
  void sort(Stopwatch& watch) {
    for (std::size_t sample = TileGrid::kSample;; sample *= 16) {
      make_plan(sample);
      watch.lap("plan");
      grids_.clear();
      grids_.reserve(sources_.size());
      for (const OrdinalSource& source : sources_) {
        grids_.emplace_back(source, plan_);
        if (grids_.back().misjudged()) break;
      }
      watch.lap("tiles");
      if (!grids_.back().misjudged()) return;
    }
  }

  std::span<const TileGrid> grids() const { return grids_; }
  bool sums() const { return sums_; }
  /// A sink that passes vertices on to `sink` with their ordinals.
  VertexSink* mapped(VertexSink* sink) { return positions_ ? &mapping_.emplace(*positions_, *sink) : sink; }

 private:
  void make_plan(std::size_t sample) {
    if (sums_) {
      plan_ = ordinals_.region
                  ? TileGrid::plan(sources_, *ordinals_.region, kRegionLogEdge, least_in_tile_, sample)
                  : TileGrid::plan(sources_, counts_, kSumsLogEdge, least_in_tile_, sample);
      if (!is_wasteful()) return;
      // either all slabs of a region are summed, or none
      if (ordinals_.region && plan_.touched < kMostTouchedInRegion) return;
      if (ordinals_.region) throw SumsAreWasteful();
      sums_ = false;
    }
    plan_ = TileGrid::plan(sources_, counts_, kPackedLogEdge, least_in_tile_, sample);
    if (positions_ || !is_wasteful()) return;
    std::array<bool, 3> wide;
    for (int a = 0; a < 3; ++a) wide[a] = counts_[a] > 2 * boxes_;
    if (std::ranges::find(wide, true) == wide.end()) return;
    if (ordinals_.ends.empty()) ordinals_ = ordinal_boxes(sets_, ordinals_.axes);
    positions_.emplace(ordinals_.boxes, wide);
    for (int a = 0; a < 3; ++a)
      if (wide[a]) counts_[a] = positions_->count(a);
    use_kept();
    plan_ = TileGrid::plan(sources_, counts_, kPackedLogEdge, least_in_tile_, sample);
  }

  /// True if most tiles would be empty, or if each of the boxes would be in many tiles.
  bool is_wasteful() const {
    return plan_.count() > std::max<std::size_t>(512, boxes_ / 4) || plan_.touched >= kMostTouched;
  }

  void use_kept() {
    sources_.clear();
    boxes_ = ordinals_.boxes.size();
    const std::span<const OrdinalBox> kept = ordinals_.boxes;
    std::size_t begin = 0;
    for (const std::size_t end : ordinals_.ends) {
      sources_.emplace_back(kept.subspan(begin, end - begin));
      begin = end;
    }
  }

  std::span<const BoxSet> sets_;
  Ordinals& ordinals_;
  const Options& options_;
  std::size_t least_in_tile_, boxes_ = 0;
  bool sums_;
  std::array<std::uint32_t, 3> counts_;
  std::vector<OrdinalSource> sources_;
  TileGrid::Plan plan_;
  std::vector<TileGrid> grids_;
  std::optional<Positions> positions_;
  std::optional<PositionSink> mapping_;
};

/// Makes the grid of a job and calls f(CellRunner). A tile has at least `least_in_tile` boxes if
/// possible.
template <class F>
void with_cells(CellsJob job, std::size_t least_in_tile, Report& report, F&& f) {
  const Options& options = job.options;
  const std::optional<OrdinalBox> region = job.ordinals.region;
  report.method = "cells";
  report.kernel = options.kernel == CellKernel::faces ? "faces" : "occupancy";
  const bool programs = !job.expression.is_union();
  if (programs && options.kernel == CellKernel::faces)
    throw Error(ErrorKind::usage, "the kernel faces finds unions only");
  Stopwatch watch(report);
  VertexSink* sink = job.mass ? job.mass : job.vertices;
  std::optional<RegionFilter> filter;
  if (region) sink = &filter.emplace(*region, *sink);
  const Axes& axes = job.ordinals.axes;
  if (axes[0].count() == 0) return;
  const bool sums = job.mass && options.kernel == CellKernel::occupancy &&
                    std::ranges::all_of(axes, &Axis::is_lattice) && (!region || can_be_tiled(*region));
  TiledBoxes boxes(job.sets, job.ordinals, options, least_in_tile, sums);
  boxes.sort(watch);
  CellSink cells{boxes.mapped(sink), boxes.sums() ? job.mass : nullptr, programs};
  CellRunner runner(boxes.grids(), job.expression.steps(), options, cells, report);
  f(runner);
  if (cells.sums && !programs)
    for (const TileGrid& grid : boxes.grids())
      if (grid.bounds().lo[0] < grid.bounds().hi[0]) cells.sums->extend_bounds(grid.bounds());
  watch.lap("cells");
}

}  // namespace

void combine_by_cells(CellsJob job, Report& report) {
  const std::unique_ptr<Device> device = open_device(job.options.device);
  const std::size_t least = device->info().id == "native" ? kLeastInNativeTile : kLeastInTile;
  with_cells(std::move(job), least, report, [&](CellRunner& runner) { runner.run(*device); });
}

CellBatch cut_cells(CellsJob job) {
  CellBatch batch;
  Report report;
  with_cells(std::move(job), kLeastInTile, report, [&](CellRunner& runner) { batch = runner.cut_all(); });
  return batch;
}

}  // namespace boxunion

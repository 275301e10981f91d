#include "host/external/external_union.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "core/anchored/anchored.hpp"
#include "core/base/parallel.hpp"
#include "core/boxes/cuts.hpp"
#include "core/cells/tiles.hpp"
#include "core/solid/statistics.hpp"
#include "host/device/device.hpp"
#include "host/engine/cells_method.hpp"
#include "host/engine/slices_method.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/external/load_slab.hpp"
#include "host/external/slab_files.hpp"
#include "host/external/slab_sinks.hpp"
#include "host/external/sorted_runs.hpp"
#include "host/external/survey.hpp"

namespace boxunion {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;
// Memory of a run without its boxes: the process, buffers of readers and cells in progress; batches of
// devices; rectangles of slices.
constexpr std::uint64_t kBaseBytes = 96 * kMiB, kDeviceBytes = 512 * kMiB, kSlicesBytes = 384 * kMiB;
constexpr std::uint64_t kLeastBytes = 4 * kMiB;  // for boxes
// Memory of a box in the engine, as ordinals and in tiles, or while it is sorted if axes are no lattices.
// Long boxes are in many cells each; they get more if cuts help.
constexpr std::uint64_t kLatticeBoxBytes = 112, kGeneralBoxBytes = 176, kLongBoxBytes = 400;
constexpr std::uint64_t kMostBufferBytes = 64 * kMiB;
constexpr std::size_t kMostSlabs = 64;  // slabs of one cut
constexpr double kFill = 0.85;          // estimated fill of a slab, because samples err
constexpr unsigned kMostDepth = 32;
constexpr double kMostCopies = 1.5;  // copies of a box, if all boxes fit in one slab
constexpr double kCutShare = 0.3;    // fraction of the progress that cutting takes

using Ordinal = std::uint32_t;

std::string text_of(std::uint64_t bytes) {
  return fmt::format("{} MiB", (bytes + kMiB - 1) / kMiB);
}

}  // namespace

class ExternalUnion::Run {
 public:
  Run(const BoxFile& file, const Options& options, const Budget& budget, Report& report)
      : file_(file), options_(options), budget_(budget), report_(report) {
    report_ = {};
    base_ = kBaseBytes;
    if (options.device != "native" && open_device(options.device)->info().id != "native")
      base_ += kDeviceBytes;
    if (options.method == Method::slices) base_ += kSlicesBytes;
    if (budget_.bytes < base_ + kLeastBytes)
      throw Error(ErrorKind::resources,
                  fmt::format("a memory budget of {} is too small: expected at least {}",
                              text_of(budget_.bytes), text_of(base_ + kLeastBytes)));
    Stopwatch watch(report_);
    survey_ = survey_boxes(file_, options.statistics ? &box_sums_ : nullptr);
    axes_ = survey_.lattices.axes();
    is_lattice_ = std::ranges::all_of(axes_, [](const Axis& axis) { return axis.count() > 0; });
    are_long_ = survey_.are_long();
    watch.lap("survey");
  }

  const Survey& found() const { return survey_; }
  std::uint64_t slabs() const { return slabs_; }
  const Axes& axes() const { return axes_; }
  bool is_lattice() const { return is_lattice_; }
  std::uint64_t base() const { return base_; }
  std::uint64_t bytes() const { return budget_.bytes - base_; }
  ScratchFile scratch_file() const { return ScratchFile(budget_.scratch); }
  Report& report() { return report_; }

  void expect_passes(unsigned passes) { passes_ = passes; }
  void begin_pass(std::uint64_t count) {
    ++pass_;
    pass_count_ = count;
    pass_done_ = 0;
  }
  void advance(std::uint64_t count) {
    pass_done_ += count;
    show_progress(double(pass_done_) / double(pass_count_));
  }

  /// Calls use(ordinals) with each slab, to send it through the engine.
  template <class Use>
  void run(std::uint64_t bytes, Use&& use) {
    most_boxes_ = bytes / box_bytes();
    if (budget_.slab_boxes) most_boxes_ = std::min(most_boxes_, budget_.slab_boxes);
    slab_boxes_ = are_long_ ? std::min(most_boxes_, bytes / kLongBoxBytes) : most_boxes_;
    Stopwatch watch(report_);
    if (is_lattice_) {
      const RegionOf<Ordinal> all{{0, 0, 0},
                                  {axes_[0].count() + 1, axes_[1].count() + 1, axes_[2].count() + 1}};
      solve<Ordinal>(FileSource<Ordinal>(file_, survey_, axes_), all, 0, use);
    } else {
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      const RegionOf<double> all{{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
      solve<double>(FileSource<double>(file_, survey_, axes_), all, 0, use);
    }
    watch.total();
  }

  MassProperties measure() {
    try {
      return measure_slabs();
    } catch (const SumsAreWasteful&) {
      may_be_summed_ = false;
      slabs_ = boxes_in_slabs_ = boxes_done_ = 0;
      report_.cells = {};
      return measure_slabs();
    }
  }

  template <class C>
  void unite(std::uint64_t bytes, const typename SlabVertices<C>::Take& take) {
    run(bytes, [&](Ordinals slab) {
      SlabVertices<C> sink(slab.axes, axes_, take);
      unite(std::move(slab), nullptr, sink);
    });
  }

 private:
  MassProperties measure_slabs() {
    MassTotals totals;
    MassSink whole(axes_);
    std::array<std::uint64_t, 256> masks{};
    run(bytes(), [&](Ordinals slab) {
      SlabMass sink(slab.axes, axes_, is_lattice_ ? &whole : nullptr);
      if (options_.statistics) {
        MaskCounter counter(sink);
        unite(std::move(slab), nullptr, counter);
        std::ranges::transform(masks, counter.counts(), masks.begin(), std::plus());
      } else {
        unite(std::move(slab), sums_fit_ ? &sink : nullptr, sink);
      }
      totals += sink.totals();
    });
    totals += whole.totals();
    if (options_.statistics) report_.statistics = {box_sums_.sums(), vertex_kinds(masks)};
    return totals.result();
  }

  std::uint64_t box_bytes() const { return is_lattice_ ? kLatticeBoxBytes : kGeneralBoxBytes; }

  template <class C, class Use>
  void solve_whole(const BoxSource<C>& source, const RegionOf<C>& region, Use& use) {
    Stopwatch watch(report_);
    Ordinals slab = load_slab(source, region, axes_);
    watch.lap("read");
    use(std::move(slab));
  }

  template <class C, class Use>
  void solve(const BoxSource<C>& source, const RegionOf<C>& region, unsigned depth, Use& use) {
    if (depth == 0) {
      may_be_summed_ = may_be_summed_ && are_short(source.sample());
      sums_fit_ = may_be_summed_ && can_be_summed(region, source.count());
    }
    if (source.count() <= slab_boxes_) return solve_whole(source, region, use);
    Stopwatch watch(report_);
    const double share = kFill * double(slab_boxes_) / double(source.count());
    const auto cuts = choose_cuts(source.sample(), share, kMostSlabs);
    const bool fits = source.count() <= most_boxes_;
    if (fits && (!cuts || cuts->copies > kMostCopies)) return solve_whole(source, region, use);
    if (!cuts || depth == kMostDepth)
      throw Error(
          ErrorKind::resources,
          fmt::format("{} boxes overlap so deeply that no cut separates them: they need about {} of "
                      "memory, but the budget is {}",
                      source.count(), text_of(base_ + source.count() * box_bytes()), text_of(budget_.bytes)));
    std::atomic<std::uint64_t> done = 0;
    const auto advance = [&](std::uint64_t boxes) {
      if (depth == 0) show_progress(kCutShare * double(done += boxes) / double(source.size()));
    };
    auto slabs = distribute(source, region, *cuts, buffer_bytes(), budget_.scratch, advance);
    watch.lap("cut");
    if (depth == 0) {
      for (const auto& slab : slabs) boxes_in_slabs_ += slab->count();
      sums_fit_ = may_be_summed_ && std::ranges::all_of(slabs, [&](const auto& slab) {
                    return can_be_summed(slab->region(), slab_boxes_);
                  });
    }
    for (auto& slab : slabs) {
      if (slab->count() > 0) solve<C>(*slab, slab->region(), depth + 1, use);
      slab.reset();  // frees its disk space
    }
  }

  /// True if boxes, in ordinals of lattices, would each be in few tiles for sums.
  static bool are_short(std::span<const Box> sample) {
    double touched = 0;
    for (const Box& box : sample) {
      double tiles = 1;
      for (unsigned a = 0; a < 3; ++a) tiles *= 1 + (box[a + 3] - box[a]) / (1 << kRegionLogEdge);
      touched += tiles;
    }
    return touched <= kMostTouched * double(sample.size());
  }

  /// True if the tiles of a region fit, so that it can be summed without vertices. Either all slabs are
  /// summed or none, because the vertices of one slab are no integral over it. So slabs that will be cut
  /// again are asked too.
  static bool can_be_summed(const RegionOf<Ordinal>& region, std::uint64_t boxes) {
    double tiles = 1;
    for (unsigned a = 0; a < 3; ++a) {
      const Ordinal size = region.hi[a] - region.lo[a];
      if (size >= 1u << 31) return false;
      tiles *= std::ceil(double(size) / (1 << kRegionLogEdge));
    }
    return tiles <= std::max(512.0, double(boxes) / 4);
  }
  static bool can_be_summed(const RegionOf<double>&, std::uint64_t) { return false; }  // no lattices

  /// Reports a fraction of the current pass as progress.
  void show_progress(double fraction) const {
    if (options_.progress)
      options_.progress(std::min(1.0, (pass_ + std::min(1.0, fraction)) / (1 + passes_)));
  }

  std::uint64_t buffer_bytes() const { return std::min(kMostBufferBytes, bytes() / 2); }

  /// Finds the part of the union that a slab owns. See CellsJob for `mass`.
  void unite(Ordinals slab, MassSink* mass, VertexSink& sink) {
    Options options = options_;
    const std::uint64_t count = slab.boxes.size(), all = std::max(boxes_in_slabs_, count);
    if (options.progress)
      options.progress = [&, done = boxes_done_](double fraction) {
        const double slabs = (double(done) + fraction * double(count)) / double(all);
        show_progress(boxes_in_slabs_ == 0 ? slabs : kCutShare + (1 - kCutShare) * slabs);
      };
    std::optional<CommonCorner> corner;
    if (!mass && may_sweep_corners(options)) corner = find_common_corner(slab.boxes);
    RegionFilter filter(*slab.region, sink);
    if (corner) {
      if (report_.method.empty()) report_sweep(report_);
      unite_anchored(slab.boxes, *corner, filter);
    } else if (options.method == Method::slices) {
      unite_by_slices(std::move(slab.boxes), options, filter, report_);
    } else {
      combine_by_cells({Expression::one_operand(), {}, std::move(slab), options, &sink, mass}, report_);
    }
    // do not try a failed device again
    if (!corner && report_.device == "native") options_.device = "native";
    boxes_done_ += count;
    ++slabs_;
  }

  const BoxFile& file_;
  Options options_;
  Budget budget_;
  Report& report_;
  std::uint64_t base_ = 0;
  BoxSummer box_sums_;  // if statistics are asked for
  Survey survey_;
  Axes axes_;
  bool is_lattice_ = false, are_long_ = false, may_be_summed_ = true, sums_fit_ = false;
  std::uint64_t most_boxes_ = 0;  // of a slab that fits
  std::uint64_t slab_boxes_ = 0;  // of a slab that is not cut further, if cuts help
  std::uint64_t boxes_in_slabs_ = 0, boxes_done_ = 0, slabs_ = 0;
  unsigned pass_ = 0, passes_ = 0;  // the union is pass 0
  std::uint64_t pass_count_ = 0, pass_done_ = 0;
};

ExternalUnion::ExternalUnion(const BoxFile& boxes, const Options& options, const Budget& budget,
                             Report& report)
    : run_(std::make_unique<Run>(boxes, options, budget, report)) {}
ExternalUnion::~ExternalUnion() = default;

std::uint64_t ExternalUnion::degenerate_boxes() const {
  return run_->found().degenerate;
}
std::uint64_t ExternalUnion::slabs() const {
  return run_->slabs();
}
MassProperties ExternalUnion::measure() {
  return run_->measure();
}
const Axes& ExternalUnion::axes() const {
  return run_->axes();
}
bool ExternalUnion::is_lattice() const {
  return run_->is_lattice();
}
std::uint64_t ExternalUnion::bytes() const {
  return run_->bytes();
}
std::uint64_t ExternalUnion::budget_for(std::uint64_t bytes) const {
  return run_->base() + bytes;
}
void ExternalUnion::expect_passes(unsigned passes) {
  run_->expect_passes(passes);
}
void ExternalUnion::begin_pass(std::uint64_t count) {
  run_->begin_pass(count);
}
void ExternalUnion::advance(std::uint64_t count) {
  run_->advance(count);
}
ScratchFile ExternalUnion::scratch_file() const {
  return run_->scratch_file();
}

template <class C>
void ExternalUnion::unite(std::uint64_t bytes,
                          const std::function<void(std::span<const ExternalVertex<C>>)>& take) {
  run_->unite<C>(bytes, take);
}
template void ExternalUnion::unite(std::uint64_t,
                                   const std::function<void(std::span<const ExternalVertex<Ordinal>>)>&);
template void ExternalUnion::unite(
    std::uint64_t, const std::function<void(std::span<const ExternalVertex<std::uint64_t>>)>&);

void ExternalUnion::vertices(const std::function<VertexBlocks(std::uint64_t)>& begin) {
  expect_passes(1);
  with_coordinates([&]<class C>(C) {
    SortedRuns<ExternalVertex<C>> runs(bytes() / 2, thread_count(), scratch_file());
    unite<C>(bytes() / 2, [&](std::span<const ExternalVertex<C>> vertices) { runs.add(vertices); });
    Stopwatch watch(run_->report());
    const VertexBlocks take = begin(runs.count());
    std::vector<PlacedVertex> placed;
    begin_pass(runs.count());
    runs.merge(bytes() / 2, [&](std::span<const ExternalVertex<C>> block) {
      placed.clear();
      for (const ExternalVertex<C>& v : block) {
        PlacedVertex& p = placed.emplace_back(PlacedVertex{{}, std::uint8_t(v.mask)});
        for (unsigned a = 0; a < 3; ++a) p.point[a] = external_coordinate(axes()[a], v.at[a]);
      }
      take(placed);
      advance(block.size());
    });
    watch.lap("merge and write");
    watch.total();
  });
}

}  // namespace boxunion

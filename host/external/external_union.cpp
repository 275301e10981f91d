#include "host/external/external_union.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "core/anchored/anchored.hpp"
#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"
#include "core/boxes/cuts.hpp"
#include "core/cells/tiles.hpp"
#include "core/solid/statistics.hpp"
#include "host/device/device.hpp"
#include "host/engine/cells_method.hpp"
#include "host/engine/slices_method.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/external/slab_files.hpp"
#include "host/external/sorted_runs.hpp"

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
constexpr double kLong = 0.1;  // mean extent of long boxes on their longest axis, as a fraction of the whole
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

/// The findings of one pass over a file.
struct Survey {
  LatticeScan lattices;
  std::uint64_t degenerate = 0;
  std::vector<Box> sample;

  void join(const Survey& other) {
    lattices.join(other.lattices);
    degenerate += other.degenerate;
    sample.insert(sample.end(), other.sample.begin(), other.sample.end());
  }
};

bool is_degenerate(const Box& box) {
  return box[0] == box[3] || box[1] == box[4] || box[2] == box[5];
}

/// True if many boxes span a large part of the whole.
bool are_long(std::span<const Box> sample) {
  std::array<double, 3> lo, hi;
  lo.fill(std::numeric_limits<double>::max());
  hi.fill(std::numeric_limits<double>::lowest());
  for (const Box& box : sample)
    for (unsigned a = 0; a < 3; ++a) lo[a] = std::min(lo[a], box[a]), hi[a] = std::max(hi[a], box[a + 3]);
  double sum = 0;
  for (const Box& box : sample) {
    double longest = 0;  // halved, because differences may overflow
    for (unsigned a = 0; a < 3; ++a)
      if (hi[a] > lo[a]) longest = std::max(longest, (box[a + 3] / 2 - box[a] / 2) / (hi[a] / 2 - lo[a] / 2));
    sum += longest;
  }
  return sum > kLong * double(sample.size());
}

/// Reads all boxes of a file once, and adds them to `sums` if that is not null. Throws for the first invalid
/// box.
Survey survey(const BoxFile& file, BoxSummer* sums) {
  constexpr std::uint64_t kPiece = BoxSource<double>::kPiece;
  const Sample sample(file.size(), BoxSource<double>::kSample);
  PerThread<Survey> parts;
  std::mutex mutex;
  std::atomic<std::uint64_t> bad_piece = std::numeric_limits<std::uint64_t>::max();
  std::exception_ptr error;
  const auto look = [&](std::uint64_t begin, Survey& part) {
    const BoxSet boxes = file.read(begin, std::min(begin + kPiece, file.size()));
    const std::size_t invalid = find_invalid(boxes);
    if (invalid < boxes.size()) validate(boxes[invalid], file.name_of(begin + invalid));
    part.lattices.add(boxes);
    part.degenerate += count_degenerate(boxes);
    if (sums) sums->add(boxes);
    sample.each(begin, begin + boxes.size(), [&](std::uint64_t i) {
      if (const Box box = boxes[i - begin]; !is_degenerate(box)) part.sample.push_back(box);
    });
  };
  parallel_ranges(0, (file.size() + kPiece - 1) / kPiece, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end && piece < bad_piece; ++piece) try {
        look(piece * kPiece, parts.local());
      } catch (const Error& e) {
        if (e.kind() != ErrorKind::input) throw;
        const std::lock_guard lock(mutex);
        if (piece < bad_piece) bad_piece = piece, error = std::current_exception();
      }
  });
  if (error) std::rethrow_exception(error);
  Survey all;
  parts.for_each([&](const Survey& part) { all.join(part); });
  return all;
}

/// The boxes of a file that are not degenerate.
template <class C>
class FileSource final : public BoxSource<C> {
 public:
  FileSource(const BoxFile& file, const Survey& survey, const Axes& axes)
      : file_(file), survey_(survey), axes_(axes) {}

  std::uint64_t size() const override { return file_.size(); }
  std::uint64_t count() const override { return file_.size() - survey_.degenerate; }
  void read(std::uint64_t begin, std::uint64_t end, std::vector<BoxOf<C>>& boxes) const override {
    const BoxSet all = file_.read(begin, end);
    boxes.clear();
    if constexpr (std::is_same_v<C, Ordinal>)
      OrdinalSource(all, axes_).read(0, all.size(), [&](const OrdinalBox& b) {
        boxes.push_back({b.lo[0], b.lo[1], b.lo[2], b.hi[0], b.hi[1], b.hi[2]});
      });
    else
      for (std::size_t i = 0; i < all.size(); ++i)
        if (const Box box = all[i]; !is_degenerate(box)) boxes.push_back(box);
  }
  std::vector<Box> sample() const override {
    std::vector<Box> sample = survey_.sample;
    if constexpr (std::is_same_v<C, Ordinal>)
      for (Box& box : sample)
        for (unsigned c = 0; c < 6; ++c) box[c] = double(axes_[c % 3].ordinal(box[c]));
    return sample;
  }

 private:
  const BoxFile& file_;
  const Survey& survey_;
  const Axes& axes_;
};

/// All boxes of a source, each as convert(box), in memory.
template <class T, class C, class Convert>
std::vector<T> load(const BoxSource<C>& source, Convert&& convert) {
  std::vector<T> all = with_memory("the boxes of a slab", source.count() * sizeof(T),
                                   [&] { return std::vector<T>(source.count()); });
  std::atomic<std::size_t> next = 0;
  source.each_piece([&](std::span<const BoxOf<C>> boxes) {
    std::size_t place = next.fetch_add(boxes.size());
    for (const BoxOf<C>& box : boxes) all[place++] = convert(box);
  });
  return all;
}

/// Loads a slab of lattices, on axes of its own. On a cut axis, ordinals count from 2^12 at the slab: see
/// kRegionLogEdge.
Ordinals load_slab(const BoxSource<Ordinal>& source, const RegionOf<Ordinal>& region, const Axes& axes) {
  std::array<Ordinal, 3> shift{};  // modulo 2^32
  Ordinals slab;
  OrdinalBox own;
  for (unsigned a = 0; a < 3; ++a) {
    const Ordinal lo = region.lo[a], hi = region.hi[a];
    const bool moves = lo > 0 && hi - lo < 1u << 31;
    const std::int64_t by = moves ? (std::int64_t{1} << kRegionLogEdge) - lo : 0;
    shift[a] = static_cast<Ordinal>(by);
    own.lo[a] = lo + shift[a];
    own.hi[a] = hi + shift[a];
    slab.axes[a] =
        Axis::lattice(axes[a].base() - by, axes[a].exponent(), std::min(hi, axes[a].count()) + shift[a]);
  }
  slab.boxes = load<OrdinalBox>(source, [&](const BoxOf<Ordinal>& b) {
    return OrdinalBox{{b[0] + shift[0], b[1] + shift[1], b[2] + shift[2]},
                      {b[3] + shift[0], b[4] + shift[1], b[5] + shift[2]}};
  });
  slab.ends = {slab.boxes.size()};
  slab.region = own;
  return slab;
}

/// The first ordinal of an axis whose coordinate is at least `coordinate`.
Ordinal first_ordinal(const Axis& axis, double coordinate) {
  Ordinal begin = 1, end = axis.count() + 1;
  while (begin < end) {
    const Ordinal middle = begin + (end - begin) / 2;
    if (axis.coordinate(middle) < coordinate)
      begin = middle + 1;
    else
      end = middle;
  }
  return begin;
}

/// Loads a slab of other axes, which are found anew. They must not all be lattices, because sums of a part of
/// the vertices depend on the origin of lattices.
Ordinals load_slab(const BoxSource<double>& source, const RegionOf<double>& region, const Axes&) {
  const BoxSet boxes(load<Box>(source, [](const Box& box) { return box; }));
  Ordinals slab = make_ordinals(boxes);
  if (std::ranges::all_of(slab.axes, &Axis::is_lattice)) {
    slab.axes = make_rank_axes(boxes);
    slab.boxes = ordinal_boxes(boxes, slab.axes);
  }
  slab.region.emplace();
  for (unsigned a = 0; a < 3; ++a) {
    slab.region->lo[a] = first_ordinal(slab.axes[a], region.lo[a]);
    slab.region->hi[a] = first_ordinal(slab.axes[a], region.hi[a]);
  }
  return slab;
}

/// The difference from ordinals of a slab to those of the whole, modulo 2^32, if both are lattices.
Ordinal shift(const Axis& slab, const Axis& whole) {
  return static_cast<Ordinal>(slab.base() - whole.base());
}

/// The mass of a slab. Sums over a part of the vertices depend on the origin of the coordinates. So those on
/// lattices go to `whole`, a sink of all slabs. Integrals over a region do not depend on it.
class SlabMass : public MassSink {
 public:
  SlabMass(const Axes& axes, const Axes& whole_axes, MassSink* whole) : MassSink(axes), whole_(whole) {
    for (unsigned a = 0; a < 3; ++a) shift_[a] = shift(axes[a], whole_axes[a]);
  }
  using MassSink::add;
  void add(std::span<const Vertex> vertices) override {
    if (!whole_) return MassSink::add(vertices);
    std::vector<Vertex> shifted(vertices.begin(), vertices.end());
    for (Vertex& v : shifted) v.x += shift_[0], v.y += shift_[1], v.z += shift_[2];
    whole_->add(shifted);
  }

 private:
  MassSink* whole_;
  std::array<Ordinal, 3> shift_{};
};

/// Passes on the vertices of a slab in coordinates of the whole.
template <class C>
class SlabVertices : public VertexSink {
 public:
  using Take = std::function<void(std::span<const ExternalVertex<C>>)>;

  SlabVertices(const Axes& axes, const Axes& whole, const Take& take) : axes_(axes), take_(take) {
    for (unsigned a = 0; a < 3; ++a) shift_[a] = shift(axes[a], whole[a]);
  }
  void add(std::span<const Vertex> vertices) override {
    std::vector<ExternalVertex<C>> moved;
    moved.reserve(vertices.size());
    for (const Vertex& v : vertices)
      moved.push_back({{coordinate(0, v.x), coordinate(1, v.y), coordinate(2, v.z)}, v.mask});
    take_(moved);
  }

 private:
  C coordinate(unsigned axis, Ordinal ordinal) const {
    if constexpr (std::is_same_v<C, Ordinal>)
      return ordinal + shift_[axis];
    else
      return ordered_bits(axes_[axis].coordinate(ordinal));
  }

  Axes axes_;
  const Take& take_;
  std::array<Ordinal, 3> shift_{};
};

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
    survey_ = survey(file_, options.statistics ? &box_sums_ : nullptr);
    axes_ = survey_.lattices.axes();
    is_lattice_ = std::ranges::all_of(axes_, [](const Axis& axis) { return axis.count() > 0; });
    are_long_ = are_long(survey_.sample);
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

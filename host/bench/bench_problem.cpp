#include "host/bench/bench_problem.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "boxunion/generate.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/cells/expression.hpp"
#include "core/slices/slices.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/engine/cell_stage.hpp"
#include "host/engine/cells_method.hpp"
#include "host/engine/contour_stage.hpp"
#include "host/engine/slices_method.hpp"

namespace boxunion {
namespace {

constexpr std::int64_t kUniverse = 32768;

/// A kernel of cells, and what is needed to run it.
struct CellKernelKind {
  std::string_view name;
  CellKernel kernel;
  bool sums, programs;
};
constexpr CellKernelKind kCellKernels[] = {{"cell_occupancy", CellKernel::occupancy, false, false},
                                           {"cell_occupancy_sums", CellKernel::occupancy, true, false},
                                           {"cell_boolean", CellKernel::occupancy, false, true},
                                           {"cell_boolean_sums", CellKernel::occupancy, true, true},
                                           {"cell_faces", CellKernel::faces, false, false}};
constexpr std::string_view kContour = "contour";

/// `count` cubes, divided among `sets` sets. Their volumes together have the given density.
BoxSet cubes(std::uint64_t count, Density density, std::size_t sets, std::uint64_t seed) {
  const double sum = density == Density::sparse ? 0.015 : density == Density::middle ? 0.5 : 3.0;
  const double edge = double(kUniverse) * std::cbrt(sum / double(sets) / double(count));
  return collect(
      generate_cubes(count, std::clamp<std::int64_t>(std::llround(edge), 1, kUniverse), kUniverse, seed));
}

/// Counts vertices and drops them.
class CountingSink : public VertexSink {
 public:
  void add(std::span<const Vertex> vertices) override { count += vertices.size(); }
  std::atomic<std::uint64_t> count = 0;
};

/// Keeps only the first runs of a batch, with about `cells` cells, and the data that they need.
void keep_first(CellBatch& batch, std::size_t cells) {
  std::size_t runs = 0, kept = 0;
  while (runs < batch.runs.size() && kept < cells) kept += batch.runs[runs++].count;
  batch.runs.resize(runs);
  while (batch.tiles.size() > 1 && batch.tiles[batch.tiles.size() - 2].end_run >= runs)
    batch.tiles.pop_back();
  batch.tiles.back().end_run = runs;
  batch.cells.resize(kept);
  if (!batch.programs.empty()) batch.programs.resize(kept);
  std::size_t items = 0, boxes = 0, steps = 0;
  for (const Cell& cell : batch.cells) items = std::max<std::size_t>(items, cell.first + cell.count);
  batch.items.resize(items);
  for (const std::uint32_t box : batch.items) boxes = std::max<std::size_t>(boxes, box + 1);
  batch.boxes.resize(boxes);
  for (const CellProgram& p : batch.programs) steps = std::max<std::size_t>(steps, p.first + p.count);
  batch.steps.resize(steps);
}

/// The result of cells: vertices or, for the kernels of sums, mass properties.
struct CellResult {
  Array<Vertex> vertices;
  MassProperties mass;
  friend bool operator==(const CellResult&, const CellResult&) = default;
};

class CellProblem final : public BenchProblem {
 public:
  CellProblem(const CellKernelKind& kind, Density density, std::uint32_t size) : kind_(kind) {
    const std::size_t most_cubes = std::clamp<std::size_t>(256 * std::size_t{size}, 1 << 16, 1 << 22);
    for (std::size_t count = size;; count *= 2) {
      cut(density, count);
      if (batch_.cells.size() >= size || count >= most_cubes) break;
    }
    keep_first(batch_, size);
    expected_ = result([&](const CellSink& sink) { NativeCells(kind_.kernel, sink).run(batch_); });
    describe_batch(NullSinks(*this).sink);
  }

  std::unique_ptr<BenchRunner> make_runner(Device& device, const Tuning& tuning) const override {
    return std::make_unique<Runner>(*this, device, tuning);
  }

 private:
  /// Sinks for results that are not read.
  struct NullSinks {
    explicit NullSinks(const CellProblem& problem)
        : mass(problem.axes_),
          sink{&vertices, problem.kind_.sums ? &mass : nullptr, problem.kind_.programs} {}
    CountingSink vertices;
    MassSink mass;
    CellSink sink;
  };

  class Runner final : public BenchRunner {
   public:
    Runner(const CellProblem& problem, Device& device, const Tuning& tuning)
        : problem_(problem),
          null_(problem),
          sink_(null_.sink),
          stage_(device, {.kernel = problem.kind_.kernel, .tuning = tuning}, sink_) {}

    bool check() override {
      const CellResult found = problem_.result([&](const CellSink& sink) {
        sink_ = sink;
        run();
      });
      sink_ = null_.sink;
      return found == problem_.expected_;
    }
    void run() override {
      stage_.begin(problem_.batch_);
      stage_.finish(problem_.batch_);
    }
    bool ran_natively() const override { return stage_.native_batches() != 0; }

   private:
    const CellProblem& problem_;
    NullSinks null_;
    CellSink sink_;  // the stage refers to it
    CellStage stage_;
  };

  void cut(Density density, std::size_t count) {
    const Expression expression = kind_.programs ? Expression::parse("a not b") : Expression::one_operand();
    std::vector<BoxSet> sets;
    for (std::size_t i = 0; i < expression.names().size(); ++i)
      sets.push_back(cubes(count, density, expression.names().size(), i + 1));
    axes_ = find_lattices(sets).value();
    NullSinks sinks(*this);
    tbb::task_arena one_thread(1);  // the order of the cells depends on the threads
    one_thread.execute([&] {
      batch_ = cut_cells({expression,
                          sets,
                          {axes_, {}, {}},
                          {.kernel = kind_.kernel},
                          sinks.sink.vertices,
                          sinks.sink.sums});
    });
  }

  /// The result that f(sink) produces.
  template <class F>
  CellResult result(F&& f) const {
    SolidSink vertices(axes_);
    MassSink mass(axes_);
    f(CellSink{&vertices, kind_.sums ? &mass : nullptr, kind_.programs});
    return {vertices.take().vertices, mass.result()};
  }

  void describe_batch(const CellSink& sink) {
    const auto bytes = [](const auto&... arrays) {
      return (std::uint64_t{0} + ... + std::span(arrays).size_bytes());
    };
    description_.kernel = kind_.name;
    description_.cells = batch_.cells.size();
    description_.boxes = batch_.items.size();
    description_.vertices = kind_.sums ? expected_.mass.vertices : expected_.vertices.size();
    description_.bytes_read = bytes(batch_.boxes, batch_.items, batch_.cells, batch_.runs);
    if (kind_.programs) description_.bytes_read += bytes(batch_.programs, batch_.steps);
    description_.bytes_written = kind_.sums ? sums_a_run(sink) * batch_.runs.size() * sizeof(std::uint64_t)
                                            : expected_.vertices.size() * sizeof(Vertex);
  }

  CellKernelKind kind_;
  Axes axes_;
  CellBatch batch_;
  CellResult expected_;
};

/// Contour vertices. Those of tile i are [offsets[i], offsets[i + 1]), sorted.
struct ContourResult {
  std::vector<ContourVertex> vertices;
  std::vector<std::size_t> offsets;
  friend bool operator==(const ContourResult&, const ContourResult&) = default;
};

class ContourProblem final : public BenchProblem {
 public:
  ContourProblem(Density density, std::uint32_t size) {
    const BoxSet boxes = cubes(std::max(size, 1024u), density, 1, 1);
    SlabSweep sweep(ordinal_boxes(boxes, make_axes(boxes)));
    SlabBatch batch;
    while (tiles_.tiles.size() < size && sweep.next(size, batch))
      for (std::uint32_t i = 0; i < batch.slabs() && tiles_.tiles.size() < size; ++i)
        cut_tiles(
            std::span(batch.rectangles).subspan(batch.offsets[i], batch.offsets[i + 1] - batch.offsets[i]),
            kMostTileCoordinates, tiles_);
    if (tiles_.tiles.size() > size) {
      tiles_.tiles.resize(size);
      tiles_.rectangles.resize(tiles_.tiles.back().first + tiles_.tiles.back().count);
    }
    const std::unique_ptr<Device> native = open_device("native");
    Runner runner(*this, *native, {});
    runner.run();
    expected_ = runner.result();
    description_.kernel = kContour;
    description_.cells = tiles_.tiles.size();
    description_.boxes = tiles_.rectangles.size();
    description_.vertices = expected_.vertices.size();
    description_.bytes_read =
        std::span(tiles_.tiles).size_bytes() + std::span(tiles_.rectangles).size_bytes();
    description_.bytes_written =
        std::span(expected_.vertices).size_bytes() + tiles_.tiles.size() * 2 * sizeof(std::uint32_t);
  }

  std::unique_ptr<BenchRunner> make_runner(Device& device, const Tuning& tuning) const override {
    return std::make_unique<Runner>(*this, device, tuning);
  }

 private:
  class Runner final : public BenchRunner {
   public:
    Runner(const ContourProblem& problem, Device& device, const Tuning& tuning)
        : problem_(problem), stage_(device, tuning) {}

    bool check() override {
      run();
      return result() == problem_.expected_;
    }
    void run() override { stage_.run(problem_.tiles_, found_.vertices, found_.offsets); }

    /// The result of the last run.
    ContourResult result() const {
      ContourResult sorted = found_;
      for (std::size_t i = 0; i + 1 < sorted.offsets.size(); ++i)
        std::sort(sorted.vertices.begin() + std::ptrdiff_t(sorted.offsets[i]),
                  sorted.vertices.begin() + std::ptrdiff_t(sorted.offsets[i + 1]), kContourOrder);
      return sorted;
    }

   private:
    const ContourProblem& problem_;
    ContourStage stage_;
    ContourResult found_;
  };

  Tiles tiles_;
  ContourResult expected_;
};

}  // namespace

std::span<const std::string_view> benchmark_kernels() {
  static constexpr auto kNames = [] {
    std::array<std::string_view, 1 + std::size(kCellKernels)> names{kContour};
    for (std::size_t i = 0; i < std::size(kCellKernels); ++i) names[1 + i] = kCellKernels[i].name;
    return names;
  }();
  return kNames;
}

std::unique_ptr<BenchProblem> make_problem(const std::string& kernel, Density density, std::uint32_t size) {
  for (const CellKernelKind& kind : kCellKernels)
    if (kind.name == kernel) return std::make_unique<CellProblem>(kind, density, size);
  return std::make_unique<ContourProblem>(density, size);
}

}  // namespace boxunion

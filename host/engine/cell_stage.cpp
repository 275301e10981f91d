#include "host/engine/cell_stage.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/parallel.hpp"
#include "host/device/buffers.hpp"
#include "host/device/kernels.hpp"
#include "host/tuning/tuning.hpp"
#include "kernels/contract.h"

namespace boxunion {
namespace {

using u32 = std::uint32_t;
struct CellParameters {
  CELL_PARAMETERS
};

static_assert(sizeof(PackedBox) == 2 * sizeof(std::uint64_t) &&
              sizeof(Cell) == CELL_WORDS * sizeof(std::uint64_t) &&
              sizeof(CellRun) == RUN_WORDS * sizeof(u32) && sizeof(Vertex) == VERTEX_WORDS * sizeof(u32) &&
              sizeof(CellProgram) == PROGRAM_WORDS * sizeof(u32) &&
              sizeof(CellStep) == STEP_WORDS * sizeof(u32));

/// The weights of every octant mask, in the form that the kernels of sums read.
constexpr std::array<u32, 256> kPackedWeights = [] {
  std::array<u32, 256> packed{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    const OctantProperties& p = kOctants[mask];
    packed[mask] = u32(p.vertex) << WEIGHT_VERTEX | u32(p.extreme) << WEIGHT_EXTREME |
                   (u32(p.volume) + WEIGHT_VOLUME_BIAS) << WEIGHT_VOLUME;
    for (unsigned a = 0; a < 3; ++a)
      packed[mask] |= (u32(p.area[a]) + WEIGHT_AREA_BIAS) << (WEIGHT_AREA + WEIGHT_AREA_BITS * a) |
                      (u32(p.length[a]) + WEIGHT_LENGTH_BIAS) << (WEIGHT_LENGTH + WEIGHT_LENGTH_BITS * a);
  }
  return packed;
}();

const KernelSource& source(CellKernel kernel, const CellSink& sink) {
  if (kernel == CellKernel::faces) {
    if (sink.sums || sink.programs) throw std::logic_error("the kernel faces gives vertices of unions only");
    return kernels::cell_faces();
  }
  if (sink.programs) return sink.sums ? kernels::cell_boolean_sums() : kernels::cell_boolean();
  return sink.sums ? kernels::cell_occupancy_sums() : kernels::cell_occupancy();
}

LatticeSums lattice_sums(std::span<const std::uint64_t> sums) {
  LatticeSums s;
  const auto number = [&](std::size_t i) { return static_cast<std::int64_t>(sums[i]); };
  s.vertices = sums[SUM_VERTICES];
  s.extreme = sums[SUM_EXTREME];
  s.volume = number(SUM_VOLUME);
  for (std::size_t a = 0; a < 3; ++a) s.first[a] = number(SUM_FIRST + a);
  for (std::size_t i = 0; i < 6; ++i) s.second[i] = number(SUM_SECOND + i);
  for (std::size_t a = 0; a < 3; ++a) s.area[a] = number(SUM_AREA + a);
  for (std::size_t a = 0; a < 3; ++a) s.length[a] = number(SUM_LENGTH + a);
  return s;
}

/// Adds the sums of the tiles first .. last - 1 of a batch to the sink. `sums` has those of the runs.
void add_sums(std::span<const std::uint64_t> sums, const CellBatch& batch, std::size_t first,
              std::size_t last, MassSink& sink) {
  const std::size_t each = sums.size() / batch.runs.size();
  for (std::size_t t = first; t < last; ++t) {
    LatticeSums tile = batch.tiles[t].closed;
    for (std::size_t r = t == 0 ? 0 : batch.tiles[t - 1].end_run; r < batch.tiles[t].end_run; ++r) {
      const auto of_run = sums.subspan(each * r, each);
      tile += lattice_sums(of_run);
      if (each == SUM_WORDS) continue;
      Reach reach;
      for (int a = 0; a < 3; ++a)
        reach.lo[a] = packed::field(of_run[SUM_LOWEST], a),
        reach.hi[a] = packed::field(of_run[SUM_HIGHEST], a);
      extend_bounds(sink, reach, batch.runs[r].origin);
    }
    sink.add(tile, batch.tiles[t].corner);
  }
}

}  // namespace

std::size_t sums_a_run(const CellSink& sink) {
  return sink.programs ? SUM_WORDS_WITH_PROGRAMS : SUM_WORDS;
}

void extend_bounds(MassSink& sink, const Reach& reach, const std::array<u32, 3>& origin) {
  if (reach.empty()) return;
  OrdinalBox box;
  for (int a = 0; a < 3; ++a) box.lo[a] = origin[a] + reach.lo[a], box.hi[a] = origin[a] + reach.hi[a];
  sink.extend_bounds(box);
}

NativeCells::NativeCells(CellKernel kernel, const CellSink& sink)
    : sink_(sink), source_(source(kernel, sink)) {}

void NativeCells::compute(const CellBatch& batch, void* const* buffers, u32 capacity) const {
  parallel_for_each(0, batch.runs.size(), 1, [&](std::size_t r) {
    const auto run = static_cast<u32>(r);
    const CellParameters parameters{run, run + 1, capacity, 2};
    source_.native(buffers, &parameters, 0, 1);
  });
}

void NativeCells::run(const CellBatch& batch) {
  const u32 runs = static_cast<u32>(batch.runs.size());
  if (runs == 0) return;
  u32 total[TOTAL_WORDS] = {};
  void* buffers[] = {const_cast<PackedBox*>(batch.boxes.data()),
                     const_cast<u32*>(batch.items.data()),
                     const_cast<Cell*>(batch.cells.data()),
                     const_cast<CellRun*>(batch.runs.data()),
                     nullptr,
                     total,
                     const_cast<CellProgram*>(batch.programs.data()),
                     const_cast<CellStep*>(batch.steps.data()),
                     nullptr};
  if (sink_.sums) {
    buffers[sink_.programs ? WEIGHTS_BINDING_WITH_PROGRAMS : WEIGHTS_BINDING] =
        const_cast<u32*>(kPackedWeights.data());
    const std::size_t sums = sums_a_run(sink_);
    sums_.resize(sums * runs);
    buffers[4] = sums_.data();
    compute(batch, buffers, 0);
    add_sums(sums_, batch, 0, batch.tiles.size(), *sink_.sums);
    return;
  }
  const std::size_t expected = std::min(8 * batch.items.size() + 64, std::size_t{1} << 16);
  if (vertices_.size() < expected) vertices_.resize(expected);
  for (;;) {
    total[TOTAL_FOUND] = 0;
    buffers[4] = vertices_.data();
    compute(batch, buffers, static_cast<u32>(std::min<std::size_t>(vertices_.size(), 0xffffffffu)));
    if (total[TOTAL_FOUND] <= vertices_.size()) break;
    vertices_.resize(total[TOTAL_FOUND] + total[TOTAL_FOUND] / 4);
  }
  sink_.vertices->add(std::span(vertices_).first(total[TOTAL_FOUND]));
}

CellStage::CellStage(Device& device, const Options& options, const CellSink& sink)
    : device_(device),
      sink_(sink),
      fallback_(options.fallback),
      kernel_(load(device, source(options.kernel, sink), options.tuning)),
      native_(options.kernel, sink),
      total_(device.allocate(TOTAL_WORDS * sizeof(u32))) {
  if (sink.sums) upload(device, weights_, std::span<const u32>(kPackedWeights));
}

std::size_t CellStage::capacity(std::size_t steps) const {
  const std::size_t bytes = sink_.programs ? std::max(sizeof(Cell), steps * sizeof(CellStep)) : sizeof(Cell);
  return std::min<std::size_t>(device_.info().max_buffer_bytes / (2 * bytes), std::size_t{1} << 21);
}

void CellStage::begin(const CellBatch& batch) {
  const u32 runs = static_cast<u32>(batch.runs.size());
  if (runs == 0) return;
  upload(device_, box_, std::span(batch.boxes));
  upload(device_, item_, std::span(batch.items));
  upload(device_, cell_, std::span(batch.cells));
  upload(device_, run_, std::span(batch.runs));
  if (sink_.programs) {
    upload(device_, program_, std::span(batch.programs));
    upload(device_, step_, std::span(batch.steps));
  }
  if (sink_.sums)
    reserve(device_, out_, sums_a_run(sink_) * runs * sizeof(std::uint64_t));
  else
    reserve(device_, out_,
            std::min(device_.info().max_buffer_bytes, (8 * batch.items.size() + 64) * sizeof(Vertex)));
  dispatch(0, runs);
}

void CellStage::dispatch(u32 first_run, u32 end_run) {
  const std::size_t capacity = out_->bytes() / sizeof(Vertex);
  const CellParameters parameters{first_run, end_run,
                                  static_cast<u32>(std::min<std::size_t>(capacity, 0xffffffffu)), 2};
  std::vector<Buffer*> buffers{box_.get(), item_.get(), cell_.get(), run_.get(), out_.get(), total_.get()};
  if (sink_.programs) buffers.insert(buffers.end(), {program_.get(), step_.get()});
  if (sink_.sums) buffers.push_back(weights_.get());
  device_.clear(*total_, total_->bytes());
  device_.dispatch(*kernel_, buffers, std::as_bytes(std::span(&parameters, 1)), end_run - first_run);
  device_.download(*total_, 0, total_->bytes());
}

void CellStage::finish(const CellBatch& batch) {
  const u32 runs = static_cast<u32>(batch.runs.size());
  if (runs == 0) return;
  const std::size_t sums_each = sums_a_run(sink_);
  if (sink_.sums) device_.download(*out_, 0, sums_each * runs * sizeof(std::uint64_t));
  device_.wait();
  const auto total = total_->view<u32>();
  bool complete = total[TOTAL_CUT_SHORT] == 0;
  if (complete && sink_.sums) {
    const auto sums = out_->view<std::uint64_t>().first(sums_each * runs);
    parallel_ranges(0, batch.tiles.size(), 16, [&](std::size_t begin, std::size_t end) {
      add_sums(sums, batch, begin, end, *sink_.sums);
    });
  } else if (complete) {
    std::vector<Vertex> vertices;
    vertices.reserve(total[TOTAL_FOUND]);
    complete = take_vertices(0, runs, vertices);
    if (complete)
      parallel_ranges(0, vertices.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        sink_.vertices->add(std::span(vertices).subspan(begin, end - begin));
      });
  }
  if (complete) return;
  if (!fallback_) throw Error(ErrorKind::device, "the device cuts long loops short");
  ++native_batches_;
  native_.run(batch);
}

/// Appends the vertices of a finished dispatch. If they did not fit, runs it again with a larger buffer or in
/// halves. False if the device cut loops short.
bool CellStage::take_vertices(u32 first_run, u32 end_run, std::vector<Vertex>& vertices) {
  const std::size_t most = device_.info().max_buffer_bytes / sizeof(Vertex);
  const auto again = [&](u32 first, u32 end) {
    dispatch(first, end);
    device_.wait();
    return total_->view<u32>()[TOTAL_CUT_SHORT] == 0 && take_vertices(first, end, vertices);
  };
  const u32 total = total_->view<u32>()[TOTAL_FOUND];
  if (total <= out_->bytes() / sizeof(Vertex)) {
    device_.download(*out_, 0, total * sizeof(Vertex));
    device_.wait();
    const auto found = out_->view<Vertex>().first(total);
    vertices.insert(vertices.end(), found.begin(), found.end());
    return true;
  }
  if (total <= most) {
    reserve(device_, out_, total * sizeof(Vertex));
    return again(first_run, end_run);
  }
  if (end_run - first_run == 1)
    throw Error(ErrorKind::device, "the vertices of one run of cells exceed the device's largest buffer");
  const u32 middle = first_run + (end_run - first_run) / 2;
  return again(first_run, middle) && again(middle, end_run);
}

}  // namespace boxunion

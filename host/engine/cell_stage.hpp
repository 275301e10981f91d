#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "boxunion/union.hpp"
#include "core/cells/cells.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/vertex_sink.hpp"
#include "host/device/device.hpp"

namespace boxunion {

/// Receives the results of cells: vertices or, on a lattice, sums over vertices.
struct CellSink {
  VertexSink* vertices = nullptr;
  MassSink* sums = nullptr;  ///< if set, nothing goes to `vertices`; not with CellKernel::faces
  bool programs = false;     ///< cells may have programs; not with CellKernel::faces
};

/// The number of sums that the kernels give for a run of cells, in the order of kernels/contract.h.
std::size_t sums_a_run(const CellSink& sink);

/// Extends the bounds of the sink by the reach of a result. Its packed coordinates count from the ordinals
/// `origin`.
void extend_bounds(MassSink& sink, const Reach& reach, const std::array<std::uint32_t, 3>& origin);

/// Computes cells on the calling thread: the native device for one batch, in the memory of the batch.
class NativeCells {
 public:
  NativeCells(CellKernel kernel, const CellSink& sink);
  void run(const CellBatch& batch);

 private:
  void compute(const CellBatch& batch, void* const* buffers, std::uint32_t capacity) const;

  const CellSink& sink_;
  const KernelSource& source_;
  std::vector<std::uint64_t> sums_;
  std::vector<Vertex> vertices_;
};

/// Computes cells on a device. begin() hands over a batch and returns; finish() waits and fills the sink.
class CellStage {
 public:
  CellStage(Device& device, const Options& options, const CellSink& sink);

  /// Maximum batch size that fits the device's buffers, in boxes, items and cells, if programs have at most
  /// `steps` steps.
  std::size_t capacity(std::size_t steps) const;
  void begin(const CellBatch& batch);
  void finish(const CellBatch& batch);
  /// The number of batches so far whose loops were too long for the device, and which ran natively.
  std::size_t native_batches() const { return native_batches_; }

 private:
  void dispatch(std::uint32_t first_run, std::uint32_t end_run);
  bool take_vertices(std::uint32_t first_run, std::uint32_t end_run, std::vector<Vertex>& vertices);

  Device& device_;
  const CellSink& sink_;
  bool fallback_;
  std::unique_ptr<Kernel> kernel_;
  NativeCells native_;  // for batches whose loops are too long for the device
  std::size_t native_batches_ = 0;
  std::unique_ptr<Buffer> box_, item_, cell_, run_, out_, total_, program_, step_, weights_;
};

}  // namespace boxunion

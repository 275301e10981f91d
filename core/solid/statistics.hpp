#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "boxunion/box.hpp"
#include "boxunion/statistics.hpp"
#include "core/base/parallel.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

/// Adds up the sums of boxes, part by part.
class BoxSummer {
 public:
  BoxSummer();
  ~BoxSummer();
  /// Adds valid boxes. Parallel and thread-safe; a few nanoseconds per box.
  void add(const BoxSet& boxes);
  /// Not while another thread adds.
  BoxSums sums() const;

 private:
  struct Share;
  std::unique_ptr<PerThread<Share>> shares_;
};

/// The sums of valid boxes. Parallel.
BoxSums sum_boxes(const BoxSet& boxes);

/// Counts vertices by octant mask on their way to another sink.
class MaskCounter : public VertexSink {
 public:
  /// Passes all vertices on to `next`, which must outlive the counter.
  explicit MaskCounter(VertexSink& next) : next_(next) {}
  void add(std::span<const Vertex> vertices) override;

  /// The number of vertices of each octant mask. Not while another thread adds.
  std::array<std::uint64_t, 256> counts() const;

 private:
  VertexSink& next_;
  PerThread<std::array<std::uint64_t, 256>> counts_{std::array<std::uint64_t, 256>{}};
};

/// Divides vertices, counted by octant mask, into their kinds.
VertexKinds vertex_kinds(const std::array<std::uint64_t, 256>& counts);

}  // namespace boxunion

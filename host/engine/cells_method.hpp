#pragma once

#include <span>

#include "boxunion/union.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/cells/cells.hpp"
#include "core/cells/expression.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

/// Regions that start at multiples of 2^12 can be summed directly, without vertices.
inline constexpr int kRegionLogEdge = 12;

/// Sums are found only if a box touches fewer tiles than this on average, because each tile has a copy of the
/// box.
inline constexpr double kMostTouched = 3;

/// True if boxes that share a corner are swept (core/anchored/anchored.hpp) instead of cut into cells.
inline bool may_sweep_corners(const Options& options) {
  return options.method == Method::automatic && options.kernel == CellKernel::occupancy &&
         !options.statistics &&  // Report::cells counts cells
         (options.device == "auto" || options.device == "native");
}

/// Records the sweep in a report.
inline void report_sweep(Report& report) {
  report.method = "staircase";
  report.kernel = "none";
  report.device = "native";
}

/// Thrown if sums of a region were asked for, but each box is in so many tiles that finding vertices takes
/// less time and memory.
struct SumsAreWasteful {};

/// The job of the method cells: an expression over sets of boxes.
struct CellsJob {
  const Expression& expression;
  std::span<const BoxSet> sets;  ///< the operands, in the order of the expression's names
  Ordinals ordinals;             ///< boxes on three lattices are read from the sets, unless it holds them
  const Options& options;
  VertexSink* vertices = nullptr;  ///< gets the vertices, unless `mass` is given
  MassSink* mass = nullptr;        ///< gets sums or vertices, whichever is cheaper to find
};

/// Computes a job by cells (Franklin, UNION3): boxes go into tiles, tiles into cells, and cells through a
/// kernel. Fills report.kernel, device, cells and stage times. Throws Error(usage) for the kernel faces if
/// the expression is not a union, and SumsAreWasteful if there are `mass` and a region.
void combine_by_cells(CellsJob job, Report& report);

/// All cells that combine_by_cells would pass to a device, in one batch, for benchmarks. Parts that need no
/// kernel are added to `mass`.
CellBatch cut_cells(CellsJob job);

}  // namespace boxunion

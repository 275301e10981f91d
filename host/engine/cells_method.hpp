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

/// Computes an expression over sets of boxes by cells (Franklin, UNION3): boxes go into tiles, tiles into
/// cells, and cells through a kernel. `sets` are the operands, in the order of the expression's names. Boxes
/// on three lattices are read from the sets, unless `ordinals` holds them. Throws Error(usage) for the kernel
/// faces if the expression is not a union, and SumsAreWasteful if there are `mass` and a region.
///
/// Passes the vertices to `vertices`. If `mass` is given, adds sums or vertices to it instead, whichever is
/// cheaper to find. Fills report.kernel, device, cells and stage times.
void combine_by_cells(const Expression& expression, std::span<const BoxSet> sets, Ordinals ordinals,
                      const Options& options, VertexSink* vertices, MassSink* mass, Report& report);

/// All cells that combine_by_cells would pass to a device with these arguments, in one batch, for benchmarks.
/// Parts that need no kernel are added to `mass`.
CellBatch cut_cells(const Expression& expression, std::span<const BoxSet> sets, Ordinals ordinals,
                    const Options& options, VertexSink* vertices, MassSink* mass);

}  // namespace boxunion

#pragma once

#include <span>

#include "core/boxes/axis.hpp"
#include "core/cells/expression.hpp"
#include "core/solid/mass.hpp"
#include "core/solid/vertex.hpp"
#include "host/engine/engine.hpp"

namespace boxunion {

/// Of a region that begins at multiples of 2^12 even sums can be found, not only vertices.
inline constexpr int kRegionLogEdge = 12;

/// Sums are found only where a box touches fewer tiles than this, on average: each tile has a copy of the
/// box.
inline constexpr double kMostTouched = 3;

/// True if boxes that share a corner are to be swept (core/anchored/anchored.hpp), and not cut into cells.
inline bool may_sweep_corners(const Options& options) {
  return options.method == Method::automatic && options.kernel == CellKernel::occupancy &&
         !options.statistics &&  // Report::cells counts cells
         (options.device == "auto" || options.device == "native");
}

/// Records in a report that they were swept.
inline void report_sweep(Report& report) {
  report.method = "staircase";
  report.kernel = "none";
  report.device = "native";
}

/// Thrown where sums of a region were asked for, but its boxes are in so many tiles each that vertices would
/// be found in less time and memory.
struct SumsAreWasteful {};

/// An expression over sets of boxes by cells (Franklin, UNION3): boxes into tiles, tiles into cells, cells
/// through a kernel. Boxes of three lattices, if not kept as ordinals, are read as they are.
/// `sets` are the operands, in the order of the expression's names. Throws Error(usage) for the kernel faces,
/// if the expression is not a union, and SumsAreWasteful if there are `mass` and a region.
///
/// Gives the vertices to `vertices`; or, if `mass` is given, adds to it whatever is cheaper to find, sums or
/// vertices, and `vertices` stays unused. Fills report.kernel, device, cells and stage times.
void combine_by_cells(const Expression& expression, std::span<const BoxSet> sets, Ordinals ordinals,
                      const Options& options, VertexSink* vertices, MassSink* mass, Report& report);

/// All cells that combine_by_cells would hand to a device with these arguments, in one batch, for benchmarks.
/// What needs no kernel is added to `mass`.
CellBatch cut_cells(const Expression& expression, std::span<const BoxSet> sets, Ordinals ordinals,
                    const Options& options, VertexSink* vertices, MassSink* mass);

}  // namespace boxunion

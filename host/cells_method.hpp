#pragma once

#include "core/axis.hpp"
#include "core/mass.hpp"
#include "core/vertex.hpp"
#include "host/engine.hpp"

namespace boxunion {

/// The union by cells (Franklin, UNION3): boxes into tiles, tiles into cells, cells through a kernel. Boxes
/// of three lattices are read as they are; others are turned into ordinals first.
///
/// Gives the vertices to `vertices`; or, if `mass` is given, adds to it whatever is cheaper to find, sums or
/// vertices, and `vertices` stays unused. Fills report.kernel, device, cells and stage times.
void unite_by_cells(const BoxSet& boxes, const Axes& axes, const Options& options, VertexSink* vertices,
                    MassSink* mass, Report& report);

}  // namespace boxunion

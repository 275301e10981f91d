#pragma once

#include <cstdint>

#include "boxunion/union.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/vertex_sink.hpp"
#include "kernels/contract.h"

namespace boxunion {

/// Maximum distinct coordinates of a tile on an axis for the kernel `contour`.
inline constexpr std::uint32_t kMostTileCoordinates = CONTOUR_RANKS;

/// The union by slices (López Monterde et al.). The kernel `contour` finds the contour of every slab between
/// neighboring z, and an xor merge joins neighboring slabs. Passes the vertices to `sink` in batches. Memory
/// is bounded by the boxes and one batch of slabs. Fills report.kernel, device and stage times.
void unite_by_slices(std::vector<OrdinalBox> boxes, const Options& options, VertexSink& sink, Report& report);

}  // namespace boxunion

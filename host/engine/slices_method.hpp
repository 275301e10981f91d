#pragma once

#include <cstdint>

#include "boxunion/union.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/vertex_sink.hpp"
#include "kernels/contract.h"

namespace boxunion {

/// Distinct coordinates an axis of a tile that the kernel `contour` holds.
inline constexpr std::uint32_t kMostTileCoordinates = CONTOUR_RANKS;

/// The union by slices (López Monterde et al.): the contour of every slab between neighboring z by the
/// kernel `contour`, then an xor merge of neighboring slabs. Gives the vertices to `sink` in batches; memory
/// stays bounded by the boxes and one batch of slabs. Fills report.kernel, device and stage times.
void unite_by_slices(std::vector<OrdinalBox> boxes, const Options& options, VertexSink& sink, Report& report);

}  // namespace boxunion

#pragma once

#include <array>
#include <optional>
#include <span>

#include "boxunion/box.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

// Boxes that share a corner, such as the boxes whose volume is the hypervolume of a front of points. They are
// swept in O(n log n) (staircase.hpp). Cells near the corner would each see most of the boxes.

/// For each axis, true if the shared corner is the upper end of the boxes.
using CommonCorner = std::array<bool, 3>;

/// The corner that all boxes share, if there is one. Other input costs a look at its first boxes only, unless
/// these were chosen to share a corner.
std::optional<CommonCorner> find_common_corner(const BoxSet& boxes);
std::optional<CommonCorner> find_common_corner(std::span<const OrdinalBox> boxes);

/// Passes the vertices of the union of boxes with a common corner to `sink`. Parallel.
void unite_anchored(std::span<const OrdinalBox> boxes, const CommonCorner& corner, VertexSink& sink);

/// The exact sums of the union of valid boxes with a common corner, faster than by its vertices. Nothing if
/// the coordinates differ so much that they have no common unit in 126 bits. Parallel.
std::optional<MassTotals> sum_anchored(const BoxSet& boxes, const CommonCorner& corner);

}  // namespace boxunion

#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/boxes/axis.hpp"
#include "core/boxes/box.hpp"
#include "core/solid/mass.hpp"
#include "core/solid/vertex.hpp"

namespace boxunion {

// Boxes that share a corner, such as those whose volume is the hypervolume of a front of points: swept in
// O(n log n), where every cell near the corner would see most of them (staircase.hpp).

/// For each axis whether the corner that boxes share is their upper one.
using CommonCorner = std::array<bool, 3>;

/// The corner that all boxes share, if there is one. Looks no further than the first boxes where there is
/// none, unless they were made to deceive it.
std::optional<CommonCorner> find_common_corner(const BoxSet& boxes);
std::optional<CommonCorner> find_common_corner(std::span<const OrdinalBox> boxes);

/// Gives the vertices of the union of boxes with a common corner to `sink`. Parallel.
void unite_anchored(std::span<const OrdinalBox> boxes, const CommonCorner& corner, VertexSink& sink);

/// The exact sums of the union of valid boxes with a common corner, faster than by way of its vertices.
/// Nothing if coordinates differ so much that they have no common unit in 126 bits. Parallel.
std::optional<MassTotals> sum_anchored(const BoxSet& boxes, const CommonCorner& corner);

}  // namespace boxunion

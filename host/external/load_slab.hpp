#pragma once

#include "core/boxes/ordinals.hpp"
#include "host/external/slab_files.hpp"

namespace boxunion {

/// Loads a slab of lattices, on axes of its own. On a cut axis, ordinals count from 2^12 at the slab: see
/// kRegionLogEdge.
Ordinals load_slab(const BoxSource<std::uint32_t>& source, const RegionOf<std::uint32_t>& region,
                   const Axes& axes);

/// Loads a slab of other axes, which are found anew. They must not all be lattices, because sums of a part of
/// the vertices depend on the origin of lattices.
Ordinals load_slab(const BoxSource<double>& source, const RegionOf<double>& region, const Axes& axes);

}  // namespace boxunion

#pragma once

#include <gmpxx.h>

#include <cstdint>
#include <functional>
#include <ostream>
#include <span>
#include <vector>

#include "core/base/memory.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/vertex_sink.hpp"

// References for the library: slow, simple, and independent of its formulas. Good for a few dozen distinct
// coordinates on each axis.

namespace boxunion {

/// True if a point that lies in these sets is filled. Bit i stands for set i.
using Combination = std::function<bool(std::uint64_t sets)>;

/// The vertices of the union, sorted: the octant mask of every point of the grid through all box faces.
Array<Vertex> brute_force_vertices(std::span<const OrdinalBox> boxes);
/// The same for a combination of at most 64 sets.
Array<Vertex> brute_force_vertices(std::span<const std::vector<OrdinalBox>> sets,
                                   const Combination& combination);

/// The mass properties of the union, from the voxels, voxel faces and voxel edges of the grid through all box
/// faces. Computed in rational numbers, and each rounded once.
MassProperties brute_force_mass(std::span<const Box> boxes);
/// The same for a combination of at most 64 sets.
MassProperties brute_force_mass(std::span<const std::vector<Box>> sets, const Combination& combination);

/// The nearest double, ties to even; infinite beyond the range of double.
double round_to_nearest(const mpq_class& value);

std::ostream& operator<<(std::ostream& out, const MassProperties& p);

}  // namespace boxunion

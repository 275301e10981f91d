#pragma once

#include <gmpxx.h>

#include <ostream>
#include <span>
#include <vector>

#include "core/axis.hpp"
#include "core/mass.hpp"
#include "core/vertex.hpp"

// What the library must agree with: slow, plain, and independent of its formulas. Good for a few dozen
// distinct coordinates an axis.

namespace boxunion {

/// The vertices of the union, sorted: the octant mask of every point of the grid through all box faces.
std::vector<Vertex> brute_force_vertices(std::span<const OrdinalBox> boxes);

/// The mass properties of the union from the voxels, voxel faces and voxel edges of the grid through all box
/// faces, in rational numbers, each rounded once.
MassProperties brute_force_mass(std::span<const Box> boxes);

/// The nearest double, ties to even; infinite beyond the range of double.
double round_to_nearest(const mpq_class& value);

std::ostream& operator<<(std::ostream& out, const MassProperties& p);

}  // namespace boxunion

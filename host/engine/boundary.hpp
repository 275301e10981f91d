#pragma once

#include "core/boundary/brep.hpp"
#include "core/boundary/triangulation.hpp"
#include "host/engine/engine.hpp"

namespace boxunion {

/// A boundary and its triangles, face by face.
struct Boundary {
  Brep brep;
  Triangulation triangulation;
};

/// The boundary of a union that `unite` has found. Continues its report. Throws Error(resources) if an index
/// does not fit 32 bits or memory does not suffice, and Error(interrupted) soon after options.interrupted
/// becomes true.
Boundary find_boundary(const Solid& solid, NonManifold contacts, const Options& options,
                       Report* report = nullptr);

}  // namespace boxunion

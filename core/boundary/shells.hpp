#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "boxunion/brep.hpp"
#include "core/boundary/planes.hpp"
#include "core/boundary/points.hpp"
#include "core/solid/solid_sink.hpp"

namespace boxunion {

/// The shells of the faces that find_faces found. Near-linear. If there are both several bodies and cavities,
/// each wall towards -x takes O(sqrt(cavities)) more.
Shells find_shells(const Solid& solid, const Planes& planes, const Faces& faces, NonManifold contacts);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "boxunion/brep.hpp"
#include "core/boundary/planes.hpp"
#include "core/boundary/points.hpp"
#include "core/boundary/shells.hpp"
#include "core/solid/solid_sink.hpp"

namespace boxunion {

/// The faces of a solid. Near-linear in its vertices, parallel over planes. Throws Error(resources) if an
/// offset does not fit 32 bits or memory does not suffice.
Faces find_faces(const Planes& planes, const Points& points);

/// The edges of a solid. A non-manifold edge comes once if contacts are kept, and once for each filled sector
/// if they are split.
Array<Edge> find_edges(const Planes& planes, const Points& points);

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <optional>

#include "boxunion/external.hpp"
#include "core/boundary/points.hpp"
#include "core/boundary/vertex_counts.hpp"
#include "host/external/external_union.hpp"
#include "host/files/files.hpp"

namespace boxunion {

struct ExternalBoundary {
  VertexCounts vertices;
  BoundaryCounts counts;
  bool exact = true;  ///< no coordinate was rounded
};

/// Finds the boundary of a solid that does not fit memory, writes it to `file` as vertices or as a mesh, and
/// commits the file. The bytes are the same as from memory.
///
/// Vertices are sorted on disk by the planes of each axis, and numbered. Some whole planes of them at a time
/// are treated as a solid of their own, whose faces in these planes are complete. Throws as
/// ExternalUnion::measure does, and Error(resources) that says how much memory it needs if a plane does not
/// fit.
ExternalBoundary write_boundary(ExternalUnion& solid, NonManifold contacts, bool triangles_only,
                                OutputFile file, Report& report);

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <optional>

#include "core/boundary/points.hpp"
#include "core/boundary/vertex_counts.hpp"
#include "host/external/external_union.hpp"
#include "host/files/files.hpp"

namespace boxunion {

/// Every shell that is no cavity encloses a body.
struct ShellCounts {
  std::uint64_t shells = 0, cavities = 0;
};

/// How much a boundary has.
struct BoundaryCounts {
  std::uint64_t faces = 0, holes = 0, triangles = 0;
  /// Nothing where the budget does not hold what counting them takes: shells_bytes.
  std::optional<ShellCounts> shells;
  std::uint64_t shells_bytes = 0;
};

struct ExternalBoundary {
  VertexCounts vertices;
  BoundaryCounts counts;
  bool exact = true;  ///< no coordinate was rounded
};

/// Finds the boundary of a solid that does not fit memory, writes it to `file` and commits that: its
/// vertices, or a mesh, with the same bytes as from memory.
///
/// Vertices are sorted on disk by the planes of each axis, and numbered. Whole planes of them are then a
/// solid of their own, as far as its faces in these planes go. Throws as ExternalUnion::measure does, and
/// Error(resources), which says how much it takes, where a plane does not fit.
ExternalBoundary write_boundary(ExternalUnion& solid, NonManifold contacts, bool triangles_only,
                                OutputFile file, Report& report);

}  // namespace boxunion

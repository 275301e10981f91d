#pragma once

#include <cstdint>

#include "boxunion/export.hpp"

namespace boxunion {

/// Sums over the input boxes, whether or not they overlap (UNION3, table 1). Each is exact and rounded once
/// to the nearest double. Degenerate boxes add nothing.
struct BoxSums {
  double volume = 0, area = 0, edge_length = 0;
  std::uint64_t vertices = 0;  ///< 8 per box

  friend bool operator==(const BoxSums&, const BoxSums&) = default;
};

/// The vertices of a union by their kind (UNION3, section 4).
///
/// For boxes in general position (no two faces in one plane) there are three kinds, each with its own octant
/// masks:
///   a corner of a box outside every other box: 1 octant is filled;
///   an edge of a box on a face of another one: the half-space of the face and a quarter of the other half, 5
///   octants;
///   a point on the faces of three boxes: three half-spaces, 7 octants.
/// Boxes whose faces share planes make the other masks. They also make these masks from more boxes, or from
/// boxes that only touch: a corner of a box that stands on a face of another box looks like an edge that
/// comes out of the face. Only the mask decides here, so a point counts once, however many boxes have a
/// corner there. Franklin's counts differ for such input, because Simulation of Simplicity separates the
/// boxes.
struct VertexKinds {
  std::uint64_t visible_input = 0, edge_face = 0, three_face = 0, other = 0;

  friend bool operator==(const VertexKinds&, const VertexKinds&) = default;
};

/// Counts of what the grid did with the boxes of a run (UNION3, table 1).
struct BOXUNION_API CellStatistics {
  std::uint64_t cells = 0;          ///< cells with boxes that a kernel looked at
  std::uint64_t covered_cells = 0;  ///< cells (or larger regions) covered by one box
  std::uint64_t items = 0;          ///< cell-box overlaps
  CellStatistics& operator+=(const CellStatistics& other);
};

/// The part of UNION3's table 1 that Report::cells and the mass properties do not cover.
struct Statistics {
  BoxSums boxes;
  VertexKinds vertices;
};

}  // namespace boxunion

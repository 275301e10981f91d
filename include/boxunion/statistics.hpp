#pragma once

#include <cstdint>

#include "boxunion/export.hpp"

namespace boxunion {

/// Sums over the boxes as they came, whether or not they overlap (UNION3, table 1), each exact and rounded
/// once to the nearest double. Degenerate boxes add nothing.
struct BoxSums {
  double volume = 0, area = 0, edge_length = 0;
  std::uint64_t vertices = 0;  ///< 8 a box

  friend bool operator==(const BoxSums&, const BoxSums&) = default;
};

/// The vertices of a union by what makes them (UNION3, section 4).
///
/// With boxes in general position (no two face planes alike) there are three kinds, each with octant masks of
/// its own:
///   a box corner outside every other box: 1 octant is filled;
///   an edge of a box on a face of another one: the face's half-space and a quarter of the other half, 5
///   octants;
///   a point on the faces of three boxes: three half-spaces, 7 octants.
/// Boxes whose faces share planes make the other masks; they also make masks of these kinds from more boxes
/// than that, or from boxes that only touch (where the corner of a box stands on a face of another one, it
/// looks like an edge that comes out of the face). The mask alone decides here: it is what the union looks
/// like at the point, and a point counts once however many boxes have a corner there. Franklin's counts
/// differ on such input, since Simulation of Simplicity takes it apart.
struct VertexKinds {
  std::uint64_t visible_input = 0, edge_face = 0, three_face = 0, other = 0;

  friend bool operator==(const VertexKinds&, const VertexKinds&) = default;
};

/// What the grid did with the boxes of a run (UNION3, table 1).
struct BOXUNION_API CellStatistics {
  std::uint64_t cells = 0;          ///< cells with boxes that a kernel looked at
  std::uint64_t covered_cells = 0;  ///< cells (or larger regions) that one box covers
  std::uint64_t items = 0;          ///< cell-box overlaps
  CellStatistics& operator+=(const CellStatistics& other);
};

/// What UNION3's table 1 says of a run, beside Report::cells and the mass properties.
struct Statistics {
  BoxSums boxes;
  VertexKinds vertices;
};

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "core/base/parallel.hpp"
#include "core/boxes/box.hpp"
#include "core/solid/vertex.hpp"

namespace boxunion {

/// Sums over the boxes as they came, whether or not they overlap (UNION3, table 1), each exact and rounded
/// once to the nearest double. Degenerate boxes add nothing.
struct BoxSums {
  double volume = 0, area = 0, edge_length = 0;
  std::uint64_t vertices = 0;  ///< 8 a box

  friend bool operator==(const BoxSums&, const BoxSums&) = default;
};

/// Sums up boxes that come part by part.
class BoxSummer {
 public:
  BoxSummer();
  ~BoxSummer();
  /// Adds valid boxes. Parallel, a few nanoseconds a box; thread-safe.
  void add(const BoxSet& boxes);
  /// Not while another thread adds.
  BoxSums sums() const;

 private:
  struct Share;
  std::unique_ptr<PerThread<Share>> shares_;
};

/// Sums up the boxes, which must be valid. Parallel.
BoxSums sum_boxes(const BoxSet& boxes);

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

/// Counts vertices by octant mask on their way to another sink.
class MaskCounter : public VertexSink {
 public:
  /// `next` takes all vertices too and must outlive the counter.
  explicit MaskCounter(VertexSink& next) : next_(next) {}
  void add(std::span<const Vertex> vertices) override;

  /// Vertices of each octant mask. Not while another thread adds.
  std::array<std::uint64_t, 256> counts() const;

 private:
  VertexSink& next_;
  PerThread<std::array<std::uint64_t, 256>> counts_{std::array<std::uint64_t, 256>{}};
};

/// Sorts vertices, counted by octant mask, into their kinds.
VertexKinds vertex_kinds(const std::array<std::uint64_t, 256>& counts);

}  // namespace boxunion

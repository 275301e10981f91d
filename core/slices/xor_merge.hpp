#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/contour.hpp"
#include "core/base/memory.hpp"
#include "core/base/ordered_bitset.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

/// The order of the vertices of a contour: by y, then x. A function object, so that sorting can inline it.
inline constexpr auto kContourOrder = [](const ContourVertex& a, const ContourVertex& b) {
  return a.y != b.y ? a.y < b.y : a.x < b.x;
};

/// The vertices of the solid in the plane between two neighboring slabs (López Monterde et al., section 6).
///
/// The published merge compares 2-D vertices by position and face degrees, and loses configurations. Here the
/// octant mask of a point is the quadrants of the lower contour and those of the upper one. Candidates are
/// the contour vertices of either slab, and the points where a vertical contour edge of one slab crosses a
/// horizontal edge of the other. One sweep along y over the active vertical edges finds the crossings, and
/// the quadrants of the slab that has no vertex at a candidate: O((V1 + V2 + crossings) log_64 size).
class XorMerge {
 public:
  /// For contours with x below `size`.
  explicit XorMerge(std::uint32_t size);

  /// Appends the vertices at height z to `out`, in no particular order. x stays as in the contours. Both
  /// contours must be sorted and complete.
  void operator()(std::span<const ContourVertex> lower, std::span<const ContourVertex> upper, std::uint32_t z,
                  Array<Vertex>& out);

 private:
  /// The state of one slab as the sweep line moves up: its vertical edges that cross the line.
  struct Side {
    OrderedBitset edges;
    std::vector<std::uint64_t> inside_right;  // by x: true if the slab is inside on the right of the edge
    std::span<const ContourVertex> row;       // vertices on the line

    bool right_of(std::uint32_t x) const { return inside_right[x >> 6] >> (x & 63) & 1; }
    unsigned quadrants(std::uint32_t x, std::size_t row_index) const;
    void advance();
  };
  void emit(std::uint32_t x, std::uint32_t y, unsigned lower, unsigned upper);
  void crossings(int horizontal);

  Side sides_[2];
  std::uint32_t z_ = 0;
  Array<Vertex>* out_ = nullptr;
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/contour.hpp"
#include "core/base/memory.hpp"
#include "core/base/ranks.hpp"
#include "core/boundary/planes.hpp"

namespace boxunion {

/// The x of a contour's vertices as small numbers in the same order: the ordinals, or ranks if the ordinals
/// are too sparse.
class ContourColumns {
 public:
  explicit ContourColumns(const Contour& contour);
  std::uint32_t count() const { return static_cast<std::uint32_t>(count_); }
  std::uint32_t operator[](std::size_t vertex) const {
    return ranks_.empty() ? vertices_[vertex].x : ranks_[vertex];
  }

 private:
  std::span<const ContourVertex> vertices_;
  std::size_t count_;
  Ranks ranks_;
};

/// The quadrants of a vertex where two corners touch, one of them below to the left.
inline constexpr std::uint32_t kRising = 1u << left_below | 1u << right_above;

/// Links the corners of a contour to loops, with the inside to the left.
///
/// A vertex has a corner with the same number. If two corners touch at the vertex, this is the lower one. The
/// upper corners are numbered from the number of vertices on, in the order of the vertices.
///
/// The ends of a horizontal edge are neighbors in the order of the vertices. Those of a vertical edge are
/// neighbors in a column, so the last vertex of each column is enough to find them. Bands of rows are linked
/// in parallel and joined in the columns.
class ContourLinks {
 public:
  /// Some rows: vertices [begin, end).
  struct Band {
    std::uint32_t begin, end;
    /// Corners that may be the lowest of a loop, and the leftmost of these, in order of their vertices. A
    /// loop has a lowest edge. At its left end, one edge goes right and one goes up.
    Array<std::uint32_t> beginnings;
    /// For each column, the last corner in this band or a lower one, or kNone. Arbitrary if there is only one
    /// band.
    Array<std::uint32_t> last;
  };
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Throws Error(resources) if memory does not suffice. There may be up to 2^31 - 1 vertices.
  ContourLinks(const Contour& contour, const ContourColumns& columns);

  std::span<const Band> bands() const { return bands_; }
  /// The next corner on the loop. Callers may overwrite it.
  std::uint32_t& next(std::uint32_t corner) { return next_[corner]; }
  std::uint32_t next(std::uint32_t corner) const { return next_[corner]; }
  std::uint32_t vertex(std::uint32_t corner) const {
    return std::min(corner, corner - static_cast<std::uint32_t>(vertices_.size()));  // or it wraps around
  }
  /// True if two corners touch at the vertex of a corner.
  bool touches(std::uint32_t corner) const;
  std::uint32_t upper(std::uint32_t vertex) const {
    return vertex + static_cast<std::uint32_t>(vertices_.size());
  }

 private:
  /// The end of an edge from a lower band.
  struct Dangling {
    std::uint32_t column, vertex;
  };

  void link(Band& band, const ContourColumns& column_of, std::vector<Dangling>& dangling);
  void join(const Band& lower, Band& upper, std::span<const Dangling> dangling);

  std::span<const ContourVertex> vertices_;
  std::vector<Band> bands_;
  Array<std::uint32_t> next_;
};

}  // namespace boxunion

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/evm.hpp"

namespace boxunion {

/// A rectangle of a section, in ordinals of B and C, and the box that it is a slice of.
struct SectionRectangle {
  std::uint32_t b_lo, c_lo, b_hi, c_hi;
  std::uint32_t box;
};

/// The section of a sweep along A, cut into rectangles along C: from every vertex of the section a cut runs
/// along C through the inside. (Of each line between lines of vertices these are its intervals, equal
/// neighbours along B merged: what CUDB does to a slice.)
///
/// A plane of vertices changes only rectangles that reach the region that it flips; only those that reach the
/// bounds of a part of it are taken apart and made anew.
class SectionRectangles {
 public:
  /// Passes a plane of vertices (sorted, projected). New rectangles are slices of box first_box and on, in
  /// the order of their low corners.
  void pass(const ExtremeVertices<2>& plane, std::uint32_t first_box);

  /// All of the section, sorted by their low corners.
  std::span<const SectionRectangle> all() const { return rectangles_; }
  /// What the plane changed: the boxes of the rectangles that are no more, and the new rectangles.
  std::span<const std::uint32_t> ended() const { return ended_; }
  std::span<const SectionRectangle> begun() const { return begun_; }

 private:
  /// A rectangle on the line that sweeps along B.
  struct Interval {
    std::uint32_t c_lo, c_hi;
    std::size_t rectangle;  // in renewed_
  };
  struct End {
    std::uint32_t b_hi, c_lo, c_hi;
  };
  struct Bounds {
    std::uint32_t b_lo, c_lo, b_hi, c_hi;
  };

  void find_changes(const ExtremeVertices<2>& plane);
  void take_touched();
  void renew(const ExtremeVertices<2>& plane);
  void change_line(std::uint32_t b, const ExtremeVertices<1>& flips);
  void compare(std::uint32_t first_box);
  void put_back();

  std::vector<SectionRectangle> rectangles_;  // sorted by their low corners, as all lists of them here
  std::vector<Bounds> changes_;               // of the flipped region's parts along B, in that order, closed
  std::vector<SectionRectangle> touched_, untouched_, renewed_, begun_, merged_;
  std::vector<std::uint32_t> ended_;
  std::vector<End> ends_, sorting_;  // high ends of the touched rectangles, sorted
  std::vector<Interval> line_, window_;
  ExtremeVertices<1> begin_points_, end_points_, plane_points_, moved_, flips_, old_points_, new_points_;
};

}  // namespace boxunion

#pragma once

#include <array>
#include <cstddef>
#include <ostream>
#include <span>
#include <vector>

#include "boxunion/box.hpp"

// References for the B-rep: voxels, unit squares and unit edges, joined one by one. Good for small integers.

namespace boxunion {

/// Counts of a boundary.
struct BoundaryCounts {
  std::size_t edges = 0, nonmanifold_edges = 0, faces = 0, holes = 0, shells = 0, bodies = 0;
  friend bool operator==(const BoundaryCounts&, const BoundaryCounts&) = default;
};
std::ostream& operator<<(std::ostream& out, const BoundaryCounts& counts);

/// The unit voxels of a union of boxes with integer corners.
class Voxels {
 public:
  using Index = std::array<int, 3>;
  explicit Voxels(std::span<const IntegerBox> boxes);

  /// True if the voxel from `low` to `low` + 1 is filled.
  bool filled(const Index& low) const;
  /// The body (component of voxels that share sides) of a filled voxel, counted from 0.
  int body(const Index& low) const { return bodies_[offset(low)]; }

  BoundaryCounts count() const;

 private:
  std::size_t offset(const Index& i) const;
  template <class F>
  void each(F&& f) const;

  Index lo_{}, size_{};      // with a margin of one empty voxel
  std::vector<int> bodies_;  // -1 where empty
  int body_count_ = 0;
};

}  // namespace boxunion

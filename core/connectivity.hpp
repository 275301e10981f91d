#pragma once

namespace boxunion {

/// Which boxes or voxels are neighbours.
enum class Connectivity {
  faces = 6,   ///< those that share a part of a face
  points = 26  ///< those that share any point
};

}  // namespace boxunion

#pragma once

#include <string>

#include "core/base/error.hpp"

namespace boxunion {

/// Which boxes or voxels are neighbors.
enum class Connectivity {
  faces = 6,   ///< those that share a part of a face
  points = 26  ///< those that share any point
};

/// Throws Error(usage) unless it is one of them.
inline void validate(Connectivity connectivity) {
  if (connectivity != Connectivity::faces && connectivity != Connectivity::points)
    throw Error(ErrorKind::usage,
                "connectivity is " + std::to_string(int(connectivity)) + ", expected 6 or 26");
}

}  // namespace boxunion

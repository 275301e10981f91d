#pragma once

#include <cstdint>
#include <string>

namespace boxunion {

/// How much memory a union may take, and where everything else goes.
struct Budget {
  /// The budget of the whole process on the native device: the memory that boxunion allocates, its code and
  /// its threads. It does not cover memory that the drivers of other devices allocate for themselves.
  std::uint64_t bytes = 0;
  std::string scratch;           ///< folder for nameless files
  std::uint64_t slab_boxes = 0;  ///< if not 0, the maximum number of boxes in a slab, even if more would fit
};

}  // namespace boxunion

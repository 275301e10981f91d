#pragma once

#include <cstdint>
#include <string>

namespace boxunion {

/// How much memory a union may take, and where the rest goes.
struct Budget {
  /// Of the whole process on the native device: what boxunion allocates, its code and its threads. What the
  /// drivers of other devices allocate, as far as boxunion does not ask for it, is beyond it.
  std::uint64_t bytes = 0;
  std::string scratch;           ///< folder for nameless files
  std::uint64_t slab_boxes = 0;  ///< if not 0, the most boxes of a slab, even where more would fit
};

}  // namespace boxunion

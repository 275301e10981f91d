#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/memory.hpp"

namespace boxunion {

/// A maximal stretch of voxels inside: voxels begin .. end - 1 of a row.
struct Run {
  std::uint32_t begin, end;
};

/// The runs of rows of voxels, row after row and along each row.
class VoxelRuns {
 public:
  /// `inside` has rows of `width` < 2^32 voxels; a voxel is inside if it is not 0. Parallel. Throws
  /// Error(resources).
  VoxelRuns(std::span<const std::uint8_t> inside, std::size_t width);

  std::size_t size() const { return runs_.size(); }
  std::size_t rows() const { return starts_.size() - 1; }
  /// Index of the first run of a row; `row` may be rows().
  std::size_t start(std::size_t row) const { return starts_[row]; }
  const Run& operator[](std::size_t i) const { return runs_[i]; }
  std::span<const Run> row(std::size_t row) const {
    return {runs_.data() + starts_[row], runs_.data() + starts_[row + 1]};
  }

 private:
  Array<std::size_t> starts_;
  Array<Run> runs_;
};

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/files.hpp"
#include "boxunion/volume.hpp"
#include "host/files/input.hpp"
#include "host/files/output.hpp"

// The format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html

namespace boxunion::npy {

/// The header of an array. Its values are Python text, as in the file.
struct Header {
  std::string descr, fortran_order, shape;
  std::uint64_t data_offset = 0;

  bool is_fortran() const { return fortran_order == "True"; }
  /// The numbers of the shape; nothing if the shape is not a tuple of numbers.
  std::optional<std::vector<std::uint64_t>> extents() const;
};

/// Reads the header of a regular file. Throws Error(input).
Header read_header(const InputFile& file);

/// The voxels of an array of three extents: z, y and x. In Fortran order z is the first axis of its grid.
VoxelStream open_volume(std::shared_ptr<const InputFile> file, const Header& header,
                        const VolumeOptions& options);

/// Writes the header of a little-endian C-order array; the data starts at a multiple of 64 bytes.
void write_header(OutputFile& file, std::string_view descr, std::string_view shape);

}  // namespace boxunion::npy

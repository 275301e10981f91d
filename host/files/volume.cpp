#include "host/files/volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <span>

#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "host/files/files.hpp"
#include "host/files/formats.hpp"
#include "host/files/voxel_data.hpp"

namespace boxunion {
namespace {

/// The voxels of a scene, in the bounds of all of them. Reads the scene twice, so that its boxes are never
/// all in memory.
Volume filled(const InputFile& file, const VolumeOptions& options) {
  constexpr std::int32_t kFirst = std::numeric_limits<std::int32_t>::max(), kLast = -kFirst;
  IntegerBox bounds = {kFirst, kFirst, kFirst, kLast, kLast, kLast};
  vox::stream_boxes(file, options, [&](std::span<const IntegerBox> boxes) {
    for (const IntegerBox& box : boxes)
      for (std::size_t a = 0; a < 3; ++a) {
        bounds[a] = std::min(bounds[a], box[a]);
        bounds[a + 3] = std::max(bounds[a + 3], box[a + 3]);
      }
  });
  if (bounds[0] > bounds[3]) reject(file, "found no voxel");
  VoxelGrid grid;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.size[a] = std::size_t(std::int64_t{bounds[a + 3]} - bounds[a]);
    grid.origin[a] = bounds[a];
  }
  check_extents(file, grid.size);
  Volume volume(grid);
  vox::stream_boxes(file, options, [&](std::span<const IntegerBox> boxes) {
    for (const IntegerBox& box : boxes)
      for (std::int64_t z = box[2]; z < box[5]; ++z)
        for (std::int64_t y = box[1]; y < box[4]; ++y) {
          const std::size_t row =
              (std::size_t(z - bounds[2]) * grid.size[1] + std::size_t(y - bounds[1])) * grid.size[0];
          std::fill_n(&volume.inside[row + std::size_t(std::int64_t{box[0]} - bounds[0])], box[3] - box[0],
                      std::uint8_t{1});
        }
  });
  return volume;
}

}  // namespace

std::optional<VoxelStream> open_volume(std::shared_ptr<const InputFile> file, FileFormat format,
                                       const VolumeOptions& options, const std::atomic<bool>* interrupted) {
  switch (format) {
    case FileFormat::nrrd:
    case FileFormat::nhdr:
      return nrrd::open_volume(std::move(file), options, interrupted);
    case FileFormat::mha:
    case FileFormat::mhd:
      return metaimage::open_volume(std::move(file), options, interrupted);
#ifdef BOXUNION_HAVE_TIFF
    case FileFormat::tif:
    case FileFormat::tiff:
      return tiff::open_volume(std::move(file), options);
#endif
    default:
      break;
  }
  const npy::Header header = npy::read_header(*file);
  const auto extents = header.extents();
  if (!extents || extents->size() != 3) return std::nullopt;
  return npy::open_volume(std::move(file), header, options);
}

bool is_volume(const std::string& path) {
  const FileFormat format = path == "-" ? FileFormat::csv : file_format(path, kInputFormats);
  if (format != FileFormat::npy) return format != FileFormat::csv;
  const auto extents = npy::read_header(InputFile(path)).extents();
  return extents && extents->size() == 3;
}

Volume read_volume(const std::string& path, const VolumeOptions& options,
                   const std::atomic<bool>* interrupted) {
  const Interruptible scope(interrupted ? interrupted : Interruptible::flag());
  const FileFormat format = file_format(path, kVolumeFormats);
  const auto file = std::make_shared<InputFile>(path, interrupted);
  if (format == FileFormat::vox) return filled(*file, options);
  if (options.model)
    throw Error(ErrorKind::usage, fmt::format("{}: only .vox files have models to choose", file->name()));
  const auto stream = open_volume(file, format, options, interrupted);
  if (!stream) reject(*file, "found an array of boxes, expected one of voxels, of shape (z, y, x)");
  Volume volume = collect(*stream);
  const bool is_fortran = format == FileFormat::npy && stream->grid.axes[0] == 2;
  return is_fortran ? transposed(volume) : volume;
}

}  // namespace boxunion

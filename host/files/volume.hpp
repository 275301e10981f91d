#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "core/voxels/volume.hpp"

namespace boxunion {

/// What of a volume file is read.
struct VolumeOptions {
  /// Voxels with at least this value are inside; without it, those that are not 0. NaN is always outside.
  std::optional<double> threshold = std::nullopt;
  /// Of a file with several models (.vox): the one to read, counted from 1, at its own coordinates; without
  /// it, all of them where the scene has them.
  std::optional<std::uint32_t> model = std::nullopt;
};

/// Does a file hold voxels, not boxes? Told by the extension, and of .npy by the shape. Throws as read_boxes
/// (files.hpp) does.
bool is_volume(const std::string& path);

/// Reads a volume into memory: .npy (three axes), .nrrd, .nhdr, .mha, .mhd, .tif, .tiff or .vox. Its first
/// axis is the file's fastest one, but for NPY always the last one, x. A scene (.vox) fills the bounds of its
/// voxels. Throws as read_boxes (files.hpp) does.
Volume read_volume(const std::string& path, const VolumeOptions& options = {},
                   const std::atomic<bool>* interrupted = nullptr);

}  // namespace boxunion

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "boxunion/box.hpp"
#include "boxunion/components.hpp"
#include "boxunion/external.hpp"
#include "boxunion/files.hpp"
#include "boxunion/volume.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"
#include "host/files/input.hpp"
#include "host/files/output.hpp"

// The formats behind files.hpp: the types of the entries of the table in formats.cpp.

namespace boxunion {

/// An open file of boxes or voxels. It is read once.
class InputBoxes {
 public:
  virtual ~InputBoxes() = default;
  virtual bool is_volume() const = 0;
  /// All boxes. They are valid.
  virtual BoxSet read() = 0;
  /// The boxes, valid or not, for reading in pieces.
  virtual std::unique_ptr<BoxFile> open(const Budget& budget) = 0;
  /// The voxels. Throws Error(input) if the file holds boxes.
  virtual Volume read_volume() = 0;
};

/// Begins to read a file. Throws Error(input) if its first bytes are not those of the format.
using Reader = std::unique_ptr<InputBoxes> (*)(std::shared_ptr<InputFile> file, const VolumeOptions& options);

/// A file of voxels, made from their stream.
std::unique_ptr<InputBoxes> volume_input(std::shared_ptr<const InputFile> file, VoxelStream voxels);

/// The Reader of a format that has only volumes, made from a function that returns their stream.
template <VoxelStream (*open_volume)(std::shared_ptr<const InputFile>, const VolumeOptions&)>
std::unique_ptr<InputBoxes> read_volumes(std::shared_ptr<InputFile> file, const VolumeOptions& options) {
  VoxelStream voxels = open_volume(file, options);
  return volume_input(std::move(file), std::move(voxels));
}

/// Writes rows of numbers: first the beginning of a file of `count` rows, then the rows, some at a time.
struct RowFormat {
  void (*begin_boxes)(OutputFile& file, std::uint64_t count);
  void (*begin_integer_boxes)(OutputFile& file, std::uint64_t count);
  void (*boxes)(OutputFile& file, std::span<const Box> boxes);
  void (*integer_boxes)(OutputFile& file, std::span<const IntegerBox> boxes);
  void (*begin_vertices)(OutputFile& file, std::uint64_t count);
  void (*vertices)(OutputFile& file, std::span<const PlacedVertex> vertices);
  void (*begin_points)(OutputFile& file, std::uint64_t count);
  void (*points)(OutputFile& file, std::span<const Point> points);
  // These write a whole file.
  void (*labelled_boxes)(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels);
  void (*components)(OutputFile& file, std::span<const Component> components);
};

/// Writes a volume of the extents of `grid`.
struct VoxelFormat {
  void (*bytes)(OutputFile& file, const VoxelGrid& grid, std::span<const std::uint8_t> voxels);
  void (*labels)(OutputFile& file, const VoxelGrid& grid, std::span<const std::uint32_t> voxels);
};

/// See begin_mesh.
using MeshFormat = std::unique_ptr<MeshWriter> (*)(OutputFile& file, const MeshSize& size);

/// The writers of a format; null for data that it cannot hold.
struct Writer {
  const RowFormat* rows = nullptr;
  const VoxelFormat* voxels = nullptr;
  MeshFormat mesh = nullptr;
};

/// The uses of a format, apart from those of its writer.
enum Role : unsigned {
  boxes_in = 1,   ///< boxes are read
  voxels_in = 2,  ///< voxels are read
  models_in = 4,  ///< a file may have several models
  manifold = 8    ///< programs that read it expect manifolds
};

/// An entry of the table: a format with its extensions.
struct Format {
  std::array<std::string_view, 2> extensions;  ///< the second may be empty
  unsigned roles = 0;                          ///< of Role
  Reader reader = nullptr;
  Writer writer = {};
  std::string_view missing = {};  ///< the library that it needs, if boxunion was built without it

  bool serves(FileUse use) const;
};

/// The table.
std::span<const Format> formats();

/// The format of a file, by its extension. Throws Error(input) with the extensions for this use if it has
/// none of them, and Error(usage) for a format that was left out of this build.
const Format& format_of(const std::string& path, FileUse use);

/// Opens a file; "-" is CSV on standard input. Throws Error(input) where that fails and Error(usage) for
/// options that are not for what it has.
std::unique_ptr<InputBoxes> open_input(const std::string& path, FileUse use, const VolumeOptions& options);

}  // namespace boxunion

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/boundary/brep.hpp"
#include "core/boundary/triangulation.hpp"
#include "core/boxes/box.hpp"
#include "core/models/components.hpp"
#include "core/models/evm.hpp"
#include "core/solid/solid.hpp"
#include "core/voxels/volume.hpp"
#include "host/files/input.hpp"
#include "host/files/npy_header.hpp"
#include "host/files/output.hpp"
#include "host/files/volume.hpp"
#include "host/files/zip.hpp"

// The formats behind files.hpp, which says what each reads and writes.

namespace boxunion {

enum class FileFormat;
class BoxFile;

/// A file of boxes or voxels, open.
struct InputBoxes {
  std::shared_ptr<InputFile> file;
  FileFormat format;
  std::optional<VoxelStream> voxels;  ///< of a volume, but of .vox
};

/// Opens a file; "-" is CSV on standard input. Throws Error(input) where that fails and Error(usage) for
/// options that are not for what it has.
InputBoxes open_input(const std::string& path, const std::atomic<bool>* interrupted,
                      const VolumeOptions& options);

/// The voxels of a file of a format that is neither .csv nor .vox; nothing if it is an NPY file of boxes.
std::optional<VoxelStream> open_volume(std::shared_ptr<const InputFile> file, FileFormat format,
                                       const VolumeOptions& options, const std::atomic<bool>* interrupted);

}  // namespace boxunion

namespace boxunion::csv {

/// Takes boxes in the order of the file.
using BoxSink = std::function<void(std::span<const Box>)>;
/// Gives all boxes to `sink`, block by block. Calls expect(t) now and then: the file is about t times what
/// has been read.
void stream_boxes(InputFile& file, const BoxSink& sink, const std::function<void(double)>& expect = {});
BoxSet read_boxes(InputFile& file);
void write_box_header(OutputFile& file);
template <class T>
void write_box_rows(OutputFile& file, std::span<const BoxOf<T>> boxes);
void write_vertex_header(OutputFile& file);
void write_vertex_rows(OutputFile& file, std::span<const PlacedVertex> vertices);
void write_point_header(OutputFile& file);
void write_point_rows(OutputFile& file, std::span<const Point> points);
void write_labelled_boxes(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels);
void write_components(OutputFile& file, std::span<const Component> components);

}  // namespace boxunion::csv

namespace boxunion::npy {

/// An array of shape (n, 6).
BoxSet read_boxes(const std::shared_ptr<const InputFile>& file, const Header& header);
std::unique_ptr<BoxFile> open_boxes(const std::shared_ptr<const InputFile>& file, const Header& header);
/// An array of three extents, z, y and x. In Fortran order z is the first axis of its grid.
VoxelStream open_volume(std::shared_ptr<const InputFile> file, const Header& header,
                        const VolumeOptions& options);
template <class T>
void write_box_header(OutputFile& file, std::uint64_t count);
template <class T>
void write_box_rows(OutputFile& file, std::span<const BoxOf<T>> boxes);
void write_vertex_header(OutputFile& file, std::uint64_t count);
void write_vertex_rows(OutputFile& file, std::span<const PlacedVertex> vertices);
void write_point_header(OutputFile& file, std::uint64_t count);
void write_point_rows(OutputFile& file, std::span<const Point> points);
void write_labelled_boxes(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels);
void write_components(OutputFile& file, std::span<const Component> components);
/// Writes a volume of the extents of `grid` as uint8 or uint32.
template <class T>
void write_volume(OutputFile& file, const VoxelGrid& grid, std::span<const T> voxels);

}  // namespace boxunion::npy

namespace boxunion::nrrd {

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const VolumeOptions& options,
                        const std::atomic<bool>* interrupted);

}  // namespace boxunion::nrrd

namespace boxunion::metaimage {

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const VolumeOptions& options,
                        const std::atomic<bool>* interrupted);

}  // namespace boxunion::metaimage

namespace boxunion::tiff {

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const VolumeOptions& options);

}  // namespace boxunion::tiff

namespace boxunion::vox {

/// The boxes of a scene: those of each model where the scene graph has it.
std::vector<IntegerBox> read_boxes(const InputFile& file, const VolumeOptions& options);
using BoxSink = std::function<void(std::span<const IntegerBox>)>;
/// Gives the same boxes to `take`, some at a time. First calls expect(bytes), if there is one: about how much
/// memory it will take at most.
void stream_boxes(const InputFile& file, const VolumeOptions& options, const BoxSink& take,
                  const std::function<void(std::uint64_t)>& expect = {});

}  // namespace boxunion::vox

namespace boxunion::obj {

void write_header(OutputFile& file);
void write_points(OutputFile& file, std::span<const Point> points);
void write_faces(OutputFile& file, const Faces& faces, const Triangulation& triangulation,
                 bool triangles_only);

}  // namespace boxunion::obj

namespace boxunion::ply {

void write_header(OutputFile& file, std::uint64_t points, std::uint64_t triangles);
void write_points(OutputFile& file, std::span<const Point> points);
void write_triangles(OutputFile& file, std::span<const Triangle> triangles);

}  // namespace boxunion::ply

namespace boxunion::off {

void write_header(OutputFile& file, std::uint64_t points, std::uint64_t triangles);
void write_points(OutputFile& file, std::span<const Point> points);
void write_triangles(OutputFile& file, std::span<const Triangle> triangles);

}  // namespace boxunion::off

namespace boxunion::stl {

void write_header(OutputFile& file, std::uint64_t triangles);
/// Returns false if a coordinate was rounded.
bool write_triangles(OutputFile& file, std::span<const Point> points, const Faces& faces,
                     const Triangulation& triangulation);

}  // namespace boxunion::stl

namespace boxunion::threemf {

/// Writes a mesh as a package of one model: all points, then all triangles.
class Writer {
 public:
  /// Writes to `file` exactly so many points and triangles. Throws Error(resources) where the format has not
  /// so many.
  Writer(OutputFile& file, std::uint64_t points, std::uint64_t triangles);
  void write_points(std::span<const Point> points);
  void write_triangles(std::span<const Triangle> triangles);
  void finish();

 private:
  ZipWriter package_;
  std::uint64_t points_left_;
  bool has_mesh_;  ///< a mesh without triangles would be none
};

}  // namespace boxunion::threemf

#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/boundary/brep.hpp"
#include "core/boundary/triangulation.hpp"
#include "core/boxes/box.hpp"
#include "core/models/components.hpp"
#include "core/models/evm.hpp"
#include "core/solid/solid.hpp"
#include "host/files/output.hpp"
#include "host/files/volume.hpp"

namespace boxunion {

namespace threemf {
class Writer;
}

/// File formats, told by the extension, in any case.
enum class FileFormat { csv, npy, obj, ply, off, stl, threemf, nrrd, nhdr, mha, mhd, tif, tiff, vox };

/// What boxes may go to: .csv and .npy.
inline constexpr FileFormat kBoxFormats[] = {FileFormat::csv, FileFormat::npy};
/// What boxes may come from: also volumes of voxels, .nrrd, .nhdr, .mha, .mhd, .tif, .tiff and .vox.
inline constexpr FileFormat kInputFormats[] = {FileFormat::csv,  FileFormat::npy,  FileFormat::nrrd,
                                               FileFormat::nhdr, FileFormat::mha,  FileFormat::mhd,
                                               FileFormat::tif,  FileFormat::tiff, FileFormat::vox};
/// What a volume may come from.
inline constexpr FileFormat kVolumeFormats[] = {FileFormat::npy,  FileFormat::nrrd, FileFormat::nhdr,
                                                FileFormat::mha,  FileFormat::mhd,  FileFormat::tif,
                                                FileFormat::tiff, FileFormat::vox};
/// What a volume may go to.
inline constexpr FileFormat kVoxelFormats[] = {FileFormat::npy};
/// What a boundary may go to: vertices as .csv and .npy, meshes as .obj, .ply, .off, .stl and .3mf.
inline constexpr FileFormat kBoundaryFormats[] = {FileFormat::csv,    FileFormat::npy, FileFormat::obj,
                                                  FileFormat::ply,    FileFormat::off, FileFormat::stl,
                                                  FileFormat::threemf};

/// The format of a file. Throws Error(input) that names the extensions of `expected` if it is none of them,
/// and Error(usage) for .tif and .tiff where boxunion was built without libtiff.
FileFormat file_format(const std::string& path, std::span<const FileFormat> expected);

/// Is it a format of meshes, so not of boxes or vertices?
inline bool is_mesh(FileFormat format) {
  return format >= FileFormat::obj && format <= FileFormat::threemf;
}

/// Reads boxes from a .csv or .npy file, from standard input ("-") as CSV, or from a volume of voxels.
///
/// CSV: a line of six decimal numbers xmin,ymin,zmin,xmax,ymax,zmax for each box, each rounded to the nearest
/// double whatever the locale. An optional header of these names comes first; spaces round the numbers,
/// Windows line ends, blank lines and lines that start with # are allowed.
///
/// NPY: an array of shape (n, 6), in C or Fortran order, of either byte order. int32 boxes stay int32;
/// float64, float32 and int64 become doubles, and an int64 that no double equals is an error.
///
/// Volumes (NPY of shape (z, y, x), NRRD, MetaImage, TIFF stacks, MagicaVoxel) become boxes of their voxels
/// inside, as `volume` says, at the place that the file gives them: see voxel_boxes. They are streamed, never
/// all in memory.
///
/// Throws Error(input) that names the file, the line (CSV) or row (NPY), counted from 1, what is wrong and
/// what was expected; the first such line or row of the file wins. A file with a header or a shape but no box
/// is fine. Throws Error(usage) for options of volumes where the file has boxes. Where `interrupted` becomes
/// true, throws Error(interrupted). Parallel.
BoxSet read_boxes(const std::string& path, const std::atomic<bool>* interrupted = nullptr,
                  const VolumeOptions& volume = {});

/// Opens an output file of an expected format (see file_format and OutputFile), before the work that fills
/// it.
OutputFile open_output(const std::string& path, const std::atomic<bool>* interrupted = nullptr,
                       std::span<const FileFormat> expected = kBoxFormats, OutputGroup* group = nullptr);

/// Writes the boxes of one type, block by block, to a .csv or .npy file. CSV has the header and the shortest
/// decimals that read back to the same numbers; NPY is a little-endian (n, 6) array of float64 or int32.
template <class T>
class BoxWriter {
 public:
  /// Writes to `file` exactly `count` boxes.
  BoxWriter(OutputFile& file, std::uint64_t count);
  void write(std::span<const BoxOf<T>> boxes);

 private:
  OutputFile& file_;
  FileFormat format_;
};

/// Writes and commits boxes in the type they have.
void write_boxes(const BoxSet& boxes, OutputFile file);

/// Writes and commits a volume as NPY, of shape (z, y, x), type uint8 or uint32, little-endian.
template <class T>
void write_volume(const VoxelGrid& grid, std::span<const T> voxels, OutputFile file);

/// Writes vertices, block by block, to a .csv or .npy file: see write_vertices.
class VertexWriter {
 public:
  /// Writes to `file` exactly `count` vertices.
  VertexWriter(OutputFile& file, std::uint64_t count);
  void write(std::span<const PlacedVertex> vertices);

 private:
  OutputFile& file_;
  FileFormat format_;
};

/// Writes and commits the vertices of a solid, sorted by z, then y, then x.
///
/// Columns: x, y, z (coordinates), mask (octant mask, see octants.hpp), and the number of faces that meet
/// there by outward direction +x, -x, +y, -y, +z, -z: in CSV degree_px, degree_nx, degree_py, degree_ny,
/// degree_pz, degree_nz, in NPY one field `degrees` of six bytes in a structured array.
void write_vertices(const Solid& solid, OutputFile file);

/// Writes points, block by block, to a .csv or .npy file: columns x, y, z, in NPY an (n, 3) array of float64.
class PointWriter {
 public:
  /// Writes to `file` exactly `count` points.
  PointWriter(OutputFile& file, std::uint64_t count);
  void write(std::span<const Point> points);

 private:
  OutputFile& file_;
  FileFormat format_;
};

/// Writes and commits extreme vertices as points, in the order of the model.
void write_extreme_vertices(const Evm& evm, OutputFile file);

/// Writes and commits boxes as write_boxes does, each with its label: in CSV a column `label` more, in NPY a
/// structured array with the fields `box` (six numbers) and `label` (uint32).
void write_labelled_boxes(const BoxSet& boxes, std::span<const std::uint32_t> labels, OutputFile file);

/// Writes and commits a table of components in the order of their labels: columns label, boxes, volume, xmin,
/// ymin, zmin, xmax, ymax, zmax; in NPY a structured array with the fields `label` and `boxes` (uint64),
/// `volume` (float64) and `bounds` (six float64).
void write_components(std::span<const Component> components, OutputFile file);

/// Writes a boundary as a mesh, part by part: all points, then all faces.
///
/// OBJ has the faces as polygons, of which those with holes are cut into triangles, or triangles alone if
/// `triangles_only`; the other formats have triangles. OBJ, OFF and 3MF (deflated, in millimetres) are text
/// in shortest decimals that read back to the same doubles; PLY is binary, little-endian, with doubles; STL
/// is binary, with floats.
class MeshWriter {
 public:
  /// Writes to `file` exactly so many points and triangles. Throws Error(resources) where the format has not
  /// so many.
  MeshWriter(OutputFile& file, bool triangles_only, std::uint64_t points, std::uint64_t triangles);
  ~MeshWriter();

  /// Do faces refer to points by their number in the file, or else (STL) to those given with them?
  bool is_indexed() const { return format_ != FileFormat::stl; }
  void write_points(std::span<const Point> points);
  /// Throws Error(input) if a coordinate is beyond the floats that the format has.
  void write_faces(std::span<const Point> points, const Faces& faces, const Triangulation& triangulation);
  /// Completes the mesh, after all faces.
  void finish();
  /// No coordinate was rounded.
  bool exact() const { return exact_; }

 private:
  OutputFile& file_;
  FileFormat format_;
  bool triangles_only_;
  std::unique_ptr<threemf::Writer> threemf_;
  bool exact_ = true;
};

/// Writes and commits a boundary as a mesh, as MeshWriter does, in the same order whatever the number of
/// threads. Returns false if a coordinate was rounded.
bool write_mesh(const Brep& brep, const Triangulation& triangulation, bool triangles_only, OutputFile file);

}  // namespace boxunion

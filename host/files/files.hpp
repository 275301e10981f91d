#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "boxunion/box.hpp"
#include "boxunion/components.hpp"
#include "boxunion/files.hpp"
#include "boxunion/mesh.hpp"
#include "core/boundary/faces.hpp"
#include "core/models/sections.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/files/output.hpp"

namespace boxunion {

// The writers of boxunion/files.hpp, for outputs that are opened before the work that fills them.

class RowFormat;

/// The use of a file.
enum class FileUse {
  input,     ///< boxes or voxels to read
  volume,    ///< voxels to read
  scene,     ///< voxels to read, of several models
  boxes,     ///< boxes, vertices and other rows to write
  voxels,    ///< voxels to write
  boundary,  ///< vertices or a mesh to write
  mesh,      ///< a mesh to write
  manifold   ///< a mesh to write for programs that expect a manifold
};

/// The extensions of the formats for a use: ".csv or .npy".
std::string extensions(FileUse use, std::string_view last = " or ");

/// True if a file, by its extension, holds a mesh instead of boxes or vertices. Throws Error(input) for a
/// file that holds neither.
bool is_mesh(const std::string& path);

/// The default for contacts: split for formats whose readers expect manifolds.
NonManifold default_contacts(const std::string& path);

/// Opens an output file (see OutputFile), before the work that fills it. Throws Error(input) unless its
/// extension is valid for this use.
OutputFile open_output(const std::string& path, FileUse use = FileUse::boxes, OutputGroup* group = nullptr);

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
  const RowFormat& format_;
};

/// Writes and commits boxes in their type.
void write_boxes(const BoxSet& boxes, OutputFile file);

/// Writes and commits a volume as NPY, of shape (z, y, x), type uint8 or uint32, little-endian.
template <class T>
void write_volume(const VoxelGrid& grid, std::span<const T> voxels, OutputFile file);

/// Writes vertices, block by block, to a .csv or .npy file.
class VertexWriter {
 public:
  /// Writes to `file` exactly `count` vertices.
  VertexWriter(OutputFile& file, std::uint64_t count);
  void write(std::span<const PlacedVertex> vertices);

 private:
  OutputFile& file_;
  const RowFormat& format_;
};

/// Writes and commits the vertices of a solid.
void write_vertices(const Solid& solid, OutputFile file);

/// Writes points, block by block, to a .csv or .npy file: columns x, y, z, in NPY an (n, 3) array of float64.
class PointWriter {
 public:
  /// Writes to `file` exactly `count` points.
  PointWriter(OutputFile& file, std::uint64_t count);
  void write(std::span<const Point> points);

 private:
  OutputFile& file_;
  const RowFormat& format_;
};

/// Writes and commits extreme vertices as points, in the order of the model.
void write_extreme_vertices(const Evm& evm, OutputFile file);

/// Writes and commits labelled boxes.
void write_labelled_boxes(const BoxSet& boxes, std::span<const std::uint32_t> labels, OutputFile file);

/// Writes and commits a table of components.
void write_components(std::span<const Component> components, OutputFile file);

/// The size of a mesh, and the kind of its faces.
struct MeshSize {
  std::uint64_t points = 0, triangles = 0;
  bool triangles_only = false;  ///< triangles even if the format has other polygons
};

/// Writes a boundary as a mesh, part by part: all points, then all faces.
///
/// OBJ has polygons, or triangles alone if `triangles_only`. Polygons with holes are cut into triangles. The
/// other formats have triangles. OBJ, OFF and 3MF (deflated, in millimetres) are text with the shortest
/// decimals that read back to the same doubles. PLY is binary, little-endian, with doubles. STL is binary,
/// with floats.
class MeshWriter {
 public:
  virtual ~MeshWriter() = default;
  /// True if faces refer to points by their number in the file. False if the points are given with the faces
  /// (STL).
  virtual bool is_indexed() const { return true; }
  virtual void write_points(std::span<const Point> points) = 0;
  /// Throws Error(input) if a coordinate exceeds the floats of the format.
  virtual void write_faces(std::span<const Point> points, const Faces& faces,
                           const Triangulation& triangulation) = 0;
  /// Completes the mesh, after all faces.
  virtual void finish() {}
  /// True if no coordinate was rounded.
  virtual bool exact() const { return true; }
};

/// Begins a mesh of exactly so many points and triangles. Throws Error(input) if the extension is not that of
/// a mesh, and Error(resources) if the format has a lower limit.
std::unique_ptr<MeshWriter> begin_mesh(OutputFile& file, const MeshSize& size);

/// Writes and commits a boundary as a mesh, as MeshWriter does, in the same order whatever the number of
/// threads. Returns false if a coordinate was rounded.
bool write_mesh(const Brep& brep, const Triangulation& triangulation, bool triangles_only, OutputFile file);
/// The same for triangles without a boundary representation.
bool write_mesh(const Mesh& mesh, OutputFile file);

}  // namespace boxunion

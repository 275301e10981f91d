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

// The writers of boxunion/files.hpp, with outputs that are opened before the work that fills them.

class RowFormat;

/// What a file is for.
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

/// Does a file, by its extension, hold a mesh and not boxes or vertices? Throws Error(input) for a file that
/// has neither.
bool is_mesh(const std::string& path);

/// What is done about contacts unless the user says: split for formats whose readers expect manifolds.
NonManifold default_contacts(const std::string& path);

/// Opens an output file (see OutputFile), before the work that fills it. Throws Error(input) unless its
/// extension is one for this use.
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

/// Writes and commits boxes in the type they have.
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

/// How large a mesh will be, and what its faces are.
struct MeshSize {
  std::uint64_t points = 0, triangles = 0;
  bool triangles_only = false;  ///< no other polygons, even where the format has them
};

/// Writes a boundary as a mesh, part by part: all points, then all faces.
///
/// OBJ has the faces as polygons, of which those with holes are cut into triangles, or triangles alone if
/// `triangles_only`; the other formats have triangles. OBJ, OFF and 3MF (deflated, in millimetres) are text
/// in shortest decimals that read back to the same doubles; PLY is binary, little-endian, with doubles; STL
/// is binary, with floats.
class MeshWriter {
 public:
  virtual ~MeshWriter() = default;
  /// Do faces refer to points by their number in the file, or else (STL) to those given with them?
  virtual bool is_indexed() const { return true; }
  virtual void write_points(std::span<const Point> points) = 0;
  /// Throws Error(input) if a coordinate is beyond the floats that the format has.
  virtual void write_faces(std::span<const Point> points, const Faces& faces,
                           const Triangulation& triangulation) = 0;
  /// Completes the mesh, after all faces.
  virtual void finish() {}
  /// No coordinate was rounded.
  virtual bool exact() const { return true; }
};

/// Begins a mesh of exactly so many points and triangles. Throws Error(input) if the file is none of a mesh,
/// and Error(resources) where the format has not so many.
std::unique_ptr<MeshWriter> begin_mesh(OutputFile& file, const MeshSize& size);

/// Writes and commits a boundary as a mesh, as MeshWriter does, in the same order whatever the number of
/// threads. Returns false if a coordinate was rounded.
bool write_mesh(const Brep& brep, const Triangulation& triangulation, bool triangles_only, OutputFile file);
/// The same of triangles without a boundary representation.
bool write_mesh(const Mesh& mesh, OutputFile file);

}  // namespace boxunion

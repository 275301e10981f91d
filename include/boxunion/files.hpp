#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "boxunion/box.hpp"
#include "boxunion/brep.hpp"
#include "boxunion/components.hpp"
#include "boxunion/evm.hpp"
#include "boxunion/export.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/solid.hpp"
#include "boxunion/volume.hpp"

// The extension of a file decides its format, in upper or lower case. docs/formats.md describes the formats.

namespace boxunion {

/// Options for reading a volume.
struct VolumeOptions {
  /// Voxels with at least this value are inside. Without a threshold, those that are not 0. NaN is always
  /// outside.
  std::optional<double> threshold = std::nullopt;
  /// The model to read from a file with several (.vox), counted from 1, at its own coordinates. Without it,
  /// all models are read, as the scene places them.
  std::optional<std::uint32_t> model = std::nullopt;
};

/// Reads boxes from a .csv or .npy file, from standard input ("-") as CSV, or from a volume of voxels.
///
/// CSV: a line of six decimal numbers xmin,ymin,zmin,xmax,ymax,zmax for each box. Each is rounded to the
/// nearest double, in any locale. An optional header of these names comes first. Spaces around the numbers,
/// Windows line ends, blank lines and lines that start with # are allowed.
///
/// NPY: an array of shape (n, 6), in C or Fortran order and either byte order. int32 boxes stay int32.
/// float64, float32 and int64 become doubles; an int64 that no double equals is an error.
///
/// Volumes (NPY of shape (z, y, x), NRRD, MetaImage, TIFF stacks, MagicaVoxel) become boxes of the voxels
/// that are inside by `volume`, at the place that the file gives: see voxel_boxes. They are streamed, never
/// all in memory.
///
/// Throws Error(input) that names the file, the first wrong line (CSV) or row (NPY), counted from 1, what is
/// wrong and what was expected. A file with a header or a shape but no box is valid. Throws Error(usage) for
/// options of volumes if the file has boxes. Throws Error(interrupted) when `interrupted` becomes true.
/// Parallel.
BOXUNION_API BoxSet read_boxes(const std::string& path, const std::atomic<bool>* interrupted = nullptr,
                               const VolumeOptions& volume = {});

/// True if a file holds voxels instead of boxes. The extension tells, and for .npy the shape. Throws as
/// read_boxes does.
BOXUNION_API bool is_volume(const std::string& path);

/// Reads a volume into memory: .npy (three axes), .nrrd, .nhdr, .mha, .mhd, .tif, .tiff or .vox. Its first
/// axis is the fastest axis of the file; for NPY it is always the last one, x. A scene (.vox) fills the
/// bounds of its voxels. Throws as read_boxes does.
BOXUNION_API Volume read_volume(const std::string& path, const VolumeOptions& options = {},
                                const std::atomic<bool>* interrupted = nullptr);

// A file appears under its name when it is complete, and replaces any file of that name. Nothing of it is
// visible before. These functions throw Error(input) if the file cannot be created or has the extension of
// another format, Error(resources) if the disk is full, and Error(usage) for arguments that contradict each
// other.

/// Writes boxes in their type, as .csv or .npy. CSV has the header xmin,ymin,zmin,xmax,ymax,zmax and the
/// shortest decimals that read back to the same numbers. NPY is a little-endian (n, 6) array of float64 or
/// int32.
BOXUNION_API void write_boxes(const BoxSet& boxes, const std::string& path);

/// Writes a volume as .npy of shape (z, y, x), little-endian. T is std::uint8_t or std::uint32_t.
template <class T>
BOXUNION_API void write_volume(const VoxelGrid& grid, std::span<const T> voxels, const std::string& path);

/// Writes the vertices of a solid as .csv or .npy, sorted by z, then y, then x.
///
/// Columns: x, y, z (coordinates), mask (octant mask, see octants.hpp), and the number of faces that meet
/// there by outward direction +x, -x, +y, -y, +z, -z. CSV names these degree_px, degree_nx, degree_py,
/// degree_ny, degree_pz, degree_nz. NPY is a structured array with one field `degrees` of six bytes.
BOXUNION_API void write_vertices(const Solid& solid, const std::string& path);

/// Writes extreme vertices as .csv or .npy, in the order of the model: columns x, y, z, in NPY an (n, 3)
/// array of float64.
BOXUNION_API void write_extreme_vertices(const Evm& evm, const std::string& path);

/// Writes boxes as write_boxes does, each with its label. CSV has one more column, `label`. NPY is a
/// structured array with the fields `box` (six numbers) and `label` (uint32).
BOXUNION_API void write_labelled_boxes(const BoxSet& boxes, std::span<const std::uint32_t> labels,
                                       const std::string& path);

/// Writes a table of components in the order of their labels. CSV has the columns label, boxes, volume, xmin,
/// ymin, zmin, xmax, ymax, zmax. NPY is a structured array with the fields `label` and `boxes` (uint64),
/// `volume` (float64) and `bounds` (six float64).
BOXUNION_API void write_components(std::span<const Component> components, const std::string& path);

/// Writes a mesh: .obj, .ply, .off, .stl or .3mf. Returns false if a coordinate was rounded to the floats of
/// STL. Throws Error(resources) if the format cannot hold so many points or triangles.
BOXUNION_API bool write_mesh(const Mesh& mesh, const std::string& path);
/// The same for a boundary. OBJ has polygons, but triangles for faces with holes, or for all faces if
/// `triangles_only`. The other formats have triangles.
BOXUNION_API bool write_mesh(const Brep& brep, const Triangulation& triangulation, const std::string& path,
                             bool triangles_only = false);

}  // namespace boxunion

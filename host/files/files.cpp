#include "host/files/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/files/formats.hpp"

namespace boxunion {

namespace {

const char* extension_of(FileFormat format) {
  switch (format) {
    case FileFormat::csv:
      return ".csv";
    case FileFormat::npy:
      return ".npy";
    case FileFormat::obj:
      return ".obj";
    case FileFormat::ply:
      return ".ply";
    case FileFormat::off:
      return ".off";
    case FileFormat::stl:
      return ".stl";
    case FileFormat::threemf:
      return ".3mf";
    case FileFormat::nrrd:
      return ".nrrd";
    case FileFormat::nhdr:
      return ".nhdr";
    case FileFormat::mha:
      return ".mha";
    case FileFormat::mhd:
      return ".mhd";
    case FileFormat::tif:
      return ".tif";
    case FileFormat::tiff:
      return ".tiff";
    case FileFormat::vox:
      return ".vox";
  }
  return "";
}

bool is_csv(const OutputFile& file) {
  return file_format(file.path(), kBoxFormats) == FileFormat::csv;
}

}  // namespace

FileFormat file_format(const std::string& path, std::span<const FileFormat> expected) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return 'A' <= c && c <= 'Z' ? char(c + 'a' - 'A') : c; });
  std::string all;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (extension == extension_of(expected[i])) {
#ifndef BOXUNION_HAVE_TIFF
      if (expected[i] == FileFormat::tif || expected[i] == FileFormat::tiff)
        throw Error(ErrorKind::usage, fmt::format("{}: this boxunion was built without libtiff", path));
#endif
      return expected[i];
    }
    all += fmt::format("{}{}",
                       i == 0                     ? ""
                       : i + 1 == expected.size() ? " or "
                                                  : ", ",
                       extension_of(expected[i]));
  }
  throw Error(ErrorKind::input,
              extension.empty() ? fmt::format("{}: no file extension, expected {}", path, all)
                                : fmt::format("{}: unknown extension {}, expected {}", path, extension, all));
}

InputBoxes open_input(const std::string& path, const std::atomic<bool>* interrupted,
                      const VolumeOptions& options) {
  InputBoxes input;
  input.format = path == "-" ? FileFormat::csv : file_format(path, kInputFormats);
  input.file = std::make_shared<InputFile>(path, interrupted);
  const std::string& name = input.file->name();
  const bool is_scene = input.format == FileFormat::vox;
  if (options.model && !is_scene)
    throw Error(ErrorKind::usage, fmt::format("{}: only .vox files have models to choose", name));
  if (input.format != FileFormat::csv && !is_scene)
    input.voxels = open_volume(input.file, input.format, options, interrupted);
  if (options.threshold && !input.voxels && !is_scene)
    throw Error(ErrorKind::usage, fmt::format("{}: found boxes, but a threshold is for voxels", name));
  return input;
}

BoxSet read_boxes(const std::string& path, const std::atomic<bool>* interrupted,
                  const VolumeOptions& volume) {
  const Interruptible scope(interrupted ? interrupted : Interruptible::flag());
  const InputBoxes input = open_input(path, interrupted, volume);
  if (input.format == FileFormat::vox) return vox::read_boxes(*input.file, volume);
  if (input.voxels) return voxel_boxes(*input.voxels);
  return input.format == FileFormat::csv ? csv::read_boxes(*input.file)
                                         : npy::read_boxes(input.file, npy::read_header(*input.file));
}

OutputFile open_output(const std::string& path, const std::atomic<bool>* interrupted,
                       std::span<const FileFormat> expected, OutputGroup* group) {
  file_format(path, expected);
  return OutputFile(path, interrupted, group);
}

template <class T>
BoxWriter<T>::BoxWriter(OutputFile& file, std::uint64_t count)
    : file_(file), format_(file_format(file.path(), kBoxFormats)) {
  if (format_ == FileFormat::csv)
    csv::write_box_header(file_);
  else
    npy::write_box_header<T>(file_, count);
}

template <class T>
void BoxWriter<T>::write(std::span<const BoxOf<T>> boxes) {
  if (format_ == FileFormat::csv)
    csv::write_box_rows(file_, boxes);
  else
    npy::write_box_rows(file_, boxes);
}

template class BoxWriter<double>;
template class BoxWriter<std::int32_t>;

void write_boxes(const BoxSet& set, OutputFile file) {
  set.visit(
      [&]<class T>(const std::vector<BoxOf<T>>& boxes) { BoxWriter<T>(file, boxes.size()).write(boxes); });
  file.commit();
}

template <class T>
void write_volume(const VoxelGrid& grid, std::span<const T> voxels, OutputFile file) {
  validate(grid);
  if (voxels.size() != grid.voxels())
    throw Error(ErrorKind::usage, fmt::format("{} voxels are to be written, expected the {} of their grid",
                                              voxels.size(), grid.voxels()));
  npy::write_volume(file, grid, voxels);
  file.commit();
}
template void write_volume(const VoxelGrid&, std::span<const std::uint8_t>, OutputFile);
template void write_volume(const VoxelGrid&, std::span<const std::uint32_t>, OutputFile);

VertexWriter::VertexWriter(OutputFile& file, std::uint64_t count)
    : file_(file), format_(file_format(file.path(), kBoxFormats)) {
  if (format_ == FileFormat::csv)
    csv::write_vertex_header(file_);
  else
    npy::write_vertex_header(file_, count);
}

void VertexWriter::write(std::span<const PlacedVertex> vertices) {
  if (format_ == FileFormat::csv)
    csv::write_vertex_rows(file_, vertices);
  else
    npy::write_vertex_rows(file_, vertices);
}

PointWriter::PointWriter(OutputFile& file, std::uint64_t count)
    : file_(file), format_(file_format(file.path(), kBoxFormats)) {
  if (format_ == FileFormat::csv)
    csv::write_point_header(file_);
  else
    npy::write_point_header(file_, count);
}

void PointWriter::write(std::span<const Point> points) {
  if (format_ == FileFormat::csv)
    csv::write_point_rows(file_, points);
  else
    npy::write_point_rows(file_, points);
}

namespace {

/// Computes make(0) .. make(count - 1) in parallel and writes them block by block.
template <class T, class Writer, class Make>
void write_blocks(Writer writer, std::size_t count, Make&& make) {
  constexpr std::size_t kRows = 1 << 18;
  std::vector<T> block;
  for (std::size_t first = 0; first < count; first += block.size()) {
    block.resize(std::min(kRows, count - first));
    parallel_ranges(0, block.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) block[i] = make(first + i);
    });
    writer.write(block);
  }
}

}  // namespace

void write_vertices(const Solid& solid, OutputFile file) {
  const std::size_t count = solid.vertices.size();
  write_blocks<PlacedVertex>(VertexWriter(file, count), count,
                             [&](std::size_t i) { return place(solid.vertices[i], solid.axes); });
  file.commit();
}

void write_extreme_vertices(const Evm& evm, OutputFile file) {
  const std::size_t count = evm.vertices.size();
  write_blocks<Point>(PointWriter(file, count), count, [&](std::size_t i) { return evm.coordinates(i); });
  file.commit();
}

void write_labelled_boxes(const BoxSet& boxes, std::span<const std::uint32_t> labels, OutputFile file) {
  if (labels.size() != boxes.size())
    throw Error(ErrorKind::usage,
                fmt::format("{} boxes were given {} labels, expected as many", boxes.size(), labels.size()));
  is_csv(file) ? csv::write_labelled_boxes(file, boxes, labels)
               : npy::write_labelled_boxes(file, boxes, labels);
  file.commit();
}

void write_components(std::span<const Component> components, OutputFile file) {
  is_csv(file) ? csv::write_components(file, components) : npy::write_components(file, components);
  file.commit();
}

MeshWriter::MeshWriter(OutputFile& file, bool triangles_only, std::uint64_t points, std::uint64_t triangles)
    : file_(file), format_(file_format(file.path(), kBoundaryFormats)), triangles_only_(triangles_only) {
  switch (format_) {
    case FileFormat::obj:
      obj::write_header(file_);
      break;
    case FileFormat::ply:
      ply::write_header(file_, points, triangles);
      break;
    case FileFormat::off:
      off::write_header(file_, points, triangles);
      break;
    case FileFormat::stl:
      stl::write_header(file_, triangles);
      break;
    case FileFormat::threemf:
      threemf_ = std::make_unique<threemf::Writer>(file_, points, triangles);
      break;
    default:
      throw Error(ErrorKind::usage, fmt::format("{}: not a mesh format", file.path()));
  }
}

MeshWriter::~MeshWriter() = default;

void MeshWriter::write_points(std::span<const Point> points) {
  if (format_ == FileFormat::obj) obj::write_points(file_, points);
  if (format_ == FileFormat::ply) ply::write_points(file_, points);
  if (format_ == FileFormat::off) off::write_points(file_, points);
  if (threemf_) threemf_->write_points(points);
}

void MeshWriter::write_faces(std::span<const Point> points, const Faces& faces,
                             const Triangulation& triangulation) {
  if (format_ == FileFormat::obj) obj::write_faces(file_, faces, triangulation, triangles_only_);
  if (format_ == FileFormat::ply) ply::write_triangles(file_, triangulation.triangles);
  if (format_ == FileFormat::off) off::write_triangles(file_, triangulation.triangles);
  if (threemf_) threemf_->write_triangles(triangulation.triangles);
  if (format_ == FileFormat::stl) exact_ &= stl::write_triangles(file_, points, faces, triangulation);
}

void MeshWriter::finish() {
  if (threemf_) threemf_->finish();
}

bool write_mesh(const Brep& brep, const Triangulation& triangulation, bool triangles_only, OutputFile file) {
  MeshWriter writer(file, triangles_only, brep.points.size(), triangulation.triangles.size());
  writer.write_points(brep.points);
  writer.write_faces(brep.points, brep.faces, triangulation);
  writer.finish();
  file.commit();
  return writer.exact();
}

}  // namespace boxunion

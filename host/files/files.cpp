#include "host/files/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <type_traits>
#include <vector>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/boundary/orientation.hpp"
#include "host/files/formats.hpp"

namespace boxunion {

BoxSet read_boxes(const std::string& path, const std::atomic<bool>* interrupted,
                  const VolumeOptions& volume) {
  const Interruptible scope(interrupted ? interrupted : Interruptible::flag());
  return open_input(path, FileUse::input, volume)->read();
}

OutputFile open_output(const std::string& path, FileUse use, OutputGroup* group) {
  format_of(path, use);
  return OutputFile(path, group);
}

namespace {

const RowFormat& rows_of(const OutputFile& file) {
  return *format_of(file.path(), FileUse::boxes).writer.rows;
}

}  // namespace

template <class T>
BoxWriter<T>::BoxWriter(OutputFile& file, std::uint64_t count) : file_(file), format_(rows_of(file)) {
  if constexpr (std::is_same_v<T, double>)
    format_.begin_boxes(file_, count);
  else
    format_.begin_integer_boxes(file_, count);
}

template <class T>
void BoxWriter<T>::write(std::span<const BoxOf<T>> boxes) {
  if constexpr (std::is_same_v<T, double>)
    format_.boxes(file_, boxes);
  else
    format_.integer_boxes(file_, boxes);
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
  const VoxelFormat& format = *format_of(file.path(), FileUse::voxels).writer.voxels;
  if constexpr (sizeof(T) == 1)
    format.bytes(file, grid, voxels);
  else
    format.labels(file, grid, voxels);
  file.commit();
}
template void write_volume(const VoxelGrid&, std::span<const std::uint8_t>, OutputFile);
template void write_volume(const VoxelGrid&, std::span<const std::uint32_t>, OutputFile);

VertexWriter::VertexWriter(OutputFile& file, std::uint64_t count) : file_(file), format_(rows_of(file)) {
  format_.begin_vertices(file_, count);
}

void VertexWriter::write(std::span<const PlacedVertex> vertices) {
  format_.vertices(file_, vertices);
}

PointWriter::PointWriter(OutputFile& file, std::uint64_t count) : file_(file), format_(rows_of(file)) {
  format_.begin_points(file_, count);
}

void PointWriter::write(std::span<const Point> points) {
  format_.points(file_, points);
}

namespace {

/// Computes make(0) .. make(count - 1) in parallel and writes them block by block.
template <class T, class Writer, class Make>
void write_blocks(Writer writer, std::size_t count, Make&& make) {
  constexpr std::size_t kRows = 1 << 18;
  std::vector<T> block;
  for (std::size_t first = 0; first < count; first += block.size()) {
    block.resize(std::min(kRows, count - first));
    parallel_for_each(0, block.size(), 1 << 14, [&](std::size_t i) { block[i] = make(first + i); });
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
  rows_of(file).labelled_boxes(file, boxes, labels);
  file.commit();
}

void write_components(std::span<const Component> components, OutputFile file) {
  rows_of(file).components(file, components);
  file.commit();
}

std::unique_ptr<MeshWriter> begin_mesh(OutputFile& file, const MeshSize& size) {
  return format_of(file.path(), FileUse::mesh).writer.mesh(file, size);
}

bool write_mesh(const Brep& brep, const Triangulation& triangulation, bool triangles_only, OutputFile file) {
  const auto writer = begin_mesh(file, {brep.points.size(), triangulation.triangles.size(), triangles_only});
  writer->write_points(brep.points);
  writer->write_faces(brep.points, brep.faces, triangulation);
  writer->finish();
  file.commit();
  return writer->exact();
}

namespace {

/// The direction of the face of a triangle: 0 .. 5 for +x, -x, +y, -y, +z, -z.
std::uint8_t direction_of(const Triangle& triangle, std::span<const Point> points) {
  const Point &p = points[triangle[0]], &q = points[triangle[1]], &r = points[triangle[2]];
  const std::size_t axis = p[0] == q[0] && p[0] == r[0] ? 0 : p[1] == q[1] && p[1] == r[1] ? 1 : 2;
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  return std::uint8_t(2 * axis + (orientation({p[u], p[v]}, {q[u], q[v]}, {r[u], r[v]}) < 0));
}

}  // namespace

bool write_mesh(const Mesh& mesh, OutputFile file) {
  const std::size_t count = mesh.triangles.size();
  Faces faces;  // one for each triangle
  Triangulation triangulation{mesh.triangles, make_array<std::uint32_t>(count + 1, "the faces")};
  with_memory("the faces", count, [&] { faces.direction.resize(count); });
  parallel_for_each(0, count, 1 << 12, [&](std::size_t t) {
    faces.direction[t] = direction_of(mesh.triangles[t], mesh.points);
    triangulation.first[t] = std::uint32_t(t);
  });
  triangulation.first[count] = std::uint32_t(count);
  const auto writer = begin_mesh(file, {mesh.points.size(), count, true});
  writer->write_points(mesh.points);
  writer->write_faces(mesh.points, faces, triangulation);
  writer->finish();
  file.commit();
  return writer->exact();
}

void write_boxes(const BoxSet& boxes, const std::string& path) {
  write_boxes(boxes, open_output(path));
}

template <class T>
void write_volume(const VoxelGrid& grid, std::span<const T> voxels, const std::string& path) {
  write_volume(grid, voxels, open_output(path, FileUse::voxels));
}
template void write_volume(const VoxelGrid&, std::span<const std::uint8_t>, const std::string&);
template void write_volume(const VoxelGrid&, std::span<const std::uint32_t>, const std::string&);

void write_vertices(const Solid& solid, const std::string& path) {
  write_vertices(solid, open_output(path));
}

void write_extreme_vertices(const Evm& evm, const std::string& path) {
  write_extreme_vertices(evm, open_output(path));
}

void write_labelled_boxes(const BoxSet& boxes, std::span<const std::uint32_t> labels,
                          const std::string& path) {
  write_labelled_boxes(boxes, labels, open_output(path));
}

void write_components(std::span<const Component> components, const std::string& path) {
  write_components(components, open_output(path));
}

bool write_mesh(const Mesh& mesh, const std::string& path) {
  return write_mesh(mesh, open_output(path, FileUse::mesh));
}

bool write_mesh(const Brep& brep, const Triangulation& triangulation, const std::string& path,
                bool triangles_only) {
  return write_mesh(brep, triangulation, triangles_only, open_output(path, FileUse::mesh));
}

}  // namespace boxunion

#include "host/command/boundary_writer.hpp"

#include <fmt/format.h>

#include <optional>
#include <span>
#include <utility>

#include "boxunion/union.hpp"
#include "core/boundary/vertex_counts.hpp"
#include "host/command/command_results.hpp"

namespace boxunion::command {
namespace {

/// Counts of the vertices of a solid.
std::vector<Result> vertex_results(const VertexCounts& counts) {
  return {count_result("vertices", counts.vertices), count_result("edges", counts.edges),
          count_result("nonmanifold_edges", counts.nonmanifold_edges)};
}

template <class Vertices>
void add_to(VertexCounts& counts, const Vertices& vertices) {
  for (const auto& v : vertices) counts.add(v.mask);
}

BoundaryCounts counts_of(const Boundary& boundary) {
  const Faces& faces = boundary.brep.faces;
  const Shells& shells = boundary.brep.shells;
  return {.faces = faces.size(),
          .holes = faces.holes(),
          .triangles = boundary.triangulation.triangles.size(),
          .shells = ShellCounts{shells.size(), shells.cavities()}};
}

/// Counts of the rest of a boundary.
std::vector<Result> boundary_results(const BoundaryCounts& counts) {
  std::vector<Result> results = {count_result("faces", counts.faces), count_result("holes", counts.holes)};
  if (counts.shells)
    for (const Result& result :
         {count_result("shells", counts.shells->shells), count_result("cavities", counts.shells->cavities),
          count_result("bodies", counts.shells->shells - counts.shells->cavities)})
      results.push_back(result);
  results.push_back(count_result("triangles", counts.triangles));
  return results;
}

/// Writes the vertices of a union, sorted, without its faces.
VertexCounts write_vertices(ExternalUnion& external, OutputFile out) {
  VertexCounts counts;
  std::optional<VertexWriter> writer;
  external.vertices([&](std::uint64_t count) {
    writer.emplace(out, count);
    return [&](std::span<const PlacedVertex> block) {
      add_to(counts, block);
      writer->write(block);
    };
  });
  out.commit();
  return counts;
}

}  // namespace

BoundaryWriter::BoundaryWriter(const std::string& output, const BoundaryOptions& options,
                               const Common& common, OutputGroup& outputs)
    : output_(output),
      contacts_(options.nonmanifold.value_or(default_contacts(output))),
      triangles_(options.triangles),
      is_mesh_(is_mesh(output)),
      has_faces_(common.json || is_mesh_),
      file_(open_output(output, FileUse::boundary, &outputs)) {}

void BoundaryWriter::write(const Solid& solid, const Options& options, Report& report) {
  add_to(written_.vertices, solid.vertices);
  std::optional<Boundary> boundary;
  if (has_faces_) {
    boundary = find_boundary(solid, contacts_, options, &report);
    written_.counts = counts_of(*boundary);
  }
  if (is_mesh_)
    written_.exact = write_mesh(boundary->brep, boundary->triangulation, triangles_, std::move(file_));
  else
    boxunion::write_vertices(solid, std::move(file_));
}

void BoundaryWriter::write(ExternalUnion& solid, Report& report) {
  if (has_faces_)
    written_ = write_boundary(solid, contacts_, triangles_, std::move(file_), report);
  else
    written_.vertices = write_vertices(solid, std::move(file_));
}

std::vector<Result> BoundaryWriter::results() const {
  std::vector<Result> results = vertex_results(written_.vertices);
  if (has_faces_) {
    for (const Result& result : boundary_results(written_.counts)) results.push_back(result);
    if (!written_.counts.shells)
      warn(
          fmt::format("shells are not counted: counting takes {} MiB, more than half of what --memory leaves",
                      (written_.counts.shells_bytes >> 20) + 1));
  }
  if (!written_.exact)
    warn(fmt::format("{}: coordinates were rounded to the numbers of this format", output_));
  results.push_back(string_result("output", output_));
  return results;
}

}  // namespace boxunion::command

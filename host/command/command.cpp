#include "host/command/command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/boundary/vertex_counts.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/command/command_results.hpp"
#include "host/device/device.hpp"
#include "host/engine/threads.hpp"
#include "host/external/external_boundary.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"
#include "host/tuning/tuning.hpp"

namespace boxunion::command {
namespace {

std::string json_array(const std::array<double, 3>& v) {
  return fmt::format("[{}, {}, {}]", json_number(v[0]), json_number(v[1]), json_number(v[2]));
}

Result vector_result(const std::string& key, const std::array<double, 3>& v) {
  return {key, json_array(v), fmt::format("{}", fmt::join(v, " "))};
}

template <std::size_t N>
Result rows_result(const std::string& key, const std::array<std::array<double, 3>, N>& rows) {
  std::string json, text;
  for (const auto& row : rows) {
    json += (json.empty() ? "[" : ", ") + json_array(row);
    text += fmt::format("{}{}", text.empty() ? "" : "\n", fmt::join(row, " "));
  }
  return {key, json + "]", text};
}

/// The parts of UNION3's table 1 that the mass properties do not cover. No cells with method slices.
std::vector<Result> statistics_results(const Report& report) {
  std::vector<Result> results;
  if (report.method == "cells")
    results = {count_result("cells", report.cells.cells),
               count_result("covered_cells", report.cells.covered_cells),
               count_result("cell_box_overlaps", report.cells.items)};
  const auto& [boxes, vertices] = *report.statistics;
  for (const Result& result :
       {number_result("box_volume_sum", boxes.volume), number_result("box_area_sum", boxes.area),
        number_result("box_edge_length_sum", boxes.edge_length),
        count_result("input_vertices", boxes.vertices),
        count_result("visible_input_vertices", vertices.visible_input),
        count_result("edge_face_vertices", vertices.edge_face),
        count_result("three_face_vertices", vertices.three_face),
        count_result("other_vertices", vertices.other)})
    results.push_back(result);
  return results;
}

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

/// The launches of the kernels on a device, as members of a JSON object. Empty for the native device, which
/// has no choice.
std::string json_launches(const DeviceInfo& device, const Tuning& tuning) {
  std::string json;
  if (device.id == "native") return json;
  for (const std::string_view kernel : benchmark_kernels()) {
    const Launch launch = choose_launch(device, kernel, tuning);
    json += fmt::format("{}{}: {{\"shape\": {}, \"workgroup\": {}, \"tuned\": {}}}", json.empty() ? "" : ", ",
                        json_string(kernel), json_string(to_string(launch.shape)), launch.workgroup,
                        tuning.tuned->find(device, kernel) == launch);
  }
  return json;
}

/// The same as a line of text, if anything was tuned.
std::string text_launches(const DeviceInfo& device, const Tuning& tuning) {
  std::string text;
  if (device.id == "native") return text;
  for (const std::string_view kernel : benchmark_kernels()) {
    const Launch launch = choose_launch(device, kernel, tuning);
    if (tuning.tuned->find(device, kernel) == launch)
      text += fmt::format("{}{} {} {}", text.empty() ? "" : ", ", kernel, to_string(launch.shape),
                          launch.workgroup);
  }
  return text.empty() ? text : fmt::format("{} tuned: {}\n", device.id, text);
}

}  // namespace

Options engine_options(const Common& common, ProgressBar& bar) {
  Options options = common.engine;
  options.progress = [&bar](double fraction) { bar.show(fraction); };
  options.warn = [&bar](const std::string& text) {
    bar.clear();
    warn(text);
  };
  options.tuning.tuned = tuned_launches();
  return options;
}

std::shared_ptr<const TunedLaunches> tuned_launches() {
  return read_tuning(tuning_path(), [](const std::string& text) { warn(text); });
}

void add_report(std::vector<Result>& results, const Report& report) {
  results.push_back(string_result("method", report.method));
  results.push_back(string_result("kernel", report.kernel));
  results.push_back(string_result("device", report.device));
  results.push_back(seconds_result(report.seconds));
}

std::vector<Result> mass_results(const MassProperties& mass) {
  return {rows_result("bounds", mass.bounds),       number_result("volume", mass.volume),
          number_result("area", mass.area),         number_result("edge_length", mass.edge_length),
          vector_result("centroid", mass.centroid), rows_result("inertia", mass.inertia),
          count_result("vertices", mass.vertices),  count_result("extreme_vertices", mass.extreme_vertices)};
}

namespace {

NonManifold contacts_of(const BoundaryOptions& options, const std::string& output) {
  return options.nonmanifold.value_or(default_contacts(output));
}

void warn_of_rounding(const std::string& output) {
  warn(fmt::format("{}: coordinates were rounded to the numbers of this format", output));
}

}  // namespace

BoundaryWriter::BoundaryWriter(const std::string& output, const BoundaryOptions& options,
                               const Common& common, OutputGroup& outputs)
    : output_(output),
      options_(options),
      common_(common),
      file_(open_output(output, FileUse::boundary, &outputs)) {}

void BoundaryWriter::write(const Solid& solid, const Options& options, Report& report) {
  const NonManifold contacts = contacts_of(options_, output_);
  VertexCounts counts;
  add_to(counts, solid.vertices);
  results_ = vertex_results(counts);
  std::optional<Boundary> boundary;
  if (common_.json || is_mesh(output_)) {
    boundary = find_boundary(solid, contacts, options, &report);
    for (const Result& result : boundary_results(counts_of(*boundary))) results_.push_back(result);
  }
  if (is_mesh(output_))
    exact_ = write_mesh(boundary->brep, boundary->triangulation, options_.triangles, std::move(file_));
  else
    write_vertices(solid, std::move(file_));
}

std::vector<Result> BoundaryWriter::results() const {
  if (!exact_) warn_of_rounding(output_);
  std::vector<Result> results = results_;
  results.push_back(string_result("output", output_));
  return results;
}

void measure(const std::string& input, const Common& common) {
  ProgressBar bar(common.quiet);
  Report report;
  std::size_t boxes = 0, degenerate = 0;
  std::optional<std::uint64_t> slabs;
  const MassProperties mass = with_threads(common.engine, [&] {
    if (common.budget) {
      const Options options = engine_options(common, bar);
      const auto file = open_boxes(input, *common.budget, common.volume);
      ExternalUnion external(*file, options, *common.budget, report);
      const MassProperties found = external.measure();
      boxes = file->size();
      degenerate = external.degenerate_boxes();
      slabs = external.slabs();
      return found;
    }
    const BoxSet set = read_boxes(input, nullptr, common.volume);
    boxes = set.size();
    degenerate = count_degenerate(set);
    return boxunion::measure(set, engine_options(common, bar), &report);
  });
  bar.clear();

  std::vector<Result> results = {count_result("boxes", boxes), count_result("degenerate_boxes", degenerate)};
  for (const Result& result : mass_results(mass)) results.push_back(result);
  if (report.statistics) {
    const std::vector<Result> statistics = statistics_results(report);
    if (common.json) {
      std::string json;
      for (const Result& result : statistics)
        json += fmt::format("{}{}: {}", json.empty() ? "" : ", ", json_string(result.key), result.json);
      results.push_back({"statistics", "{" + json + "}", ""});
    } else {
      results.insert(results.end(), statistics.begin(), statistics.end());
    }
  }
  if (slabs) results.push_back(count_result("slabs", *slabs));
  add_report(results, report);
  print_results(results, common.json);
}

namespace {

/// Writes the vertices of a union, in order and without faces.
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

/// Writes a boundary within a memory budget.
void boundary_within(const std::string& input, const std::string& output,
                     const BoundaryOptions& boundary_options, const Common& common) {
  ProgressBar bar(common.quiet);
  OutputGroup outputs;
  OutputFile out = open_output(output, FileUse::boundary, &outputs);
  const Options options = engine_options(common, bar);
  Report report;
  ExternalBoundary found;
  std::uint64_t slabs = 0;
  const bool has_faces = common.json || is_mesh(output);
  with_threads(common.engine, [&] {
    const auto file = open_boxes(input, *common.budget, common.volume);
    ExternalUnion external(*file, options, *common.budget, report);
    if (has_faces)
      found = write_boundary(external, contacts_of(boundary_options, output), boundary_options.triangles,
                             std::move(out), report);
    else
      found.vertices = write_vertices(external, std::move(out));
    slabs = external.slabs();
  });
  bar.clear();
  std::vector<Result> results = vertex_results(found.vertices);
  if (has_faces) {
    for (const Result& result : boundary_results(found.counts)) results.push_back(result);
    if (!found.counts.shells)
      warn(
          fmt::format("shells are not counted: counting takes {} MiB, more than half of what --memory leaves",
                      (found.counts.shells_bytes >> 20) + 1));
  }
  if (!found.exact) warn_of_rounding(output);
  results.push_back(string_result("output", output));
  results.push_back(count_result("slabs", slabs));
  add_report(results, report);
  print_results(results, common.json);
  outputs.publish();
}

}  // namespace

void boundary(const std::string& input, const std::string& output, const BoundaryOptions& boundary_options,
              const Common& common) {
  if (common.budget) return boundary_within(input, output, boundary_options, common);
  ProgressBar bar(common.quiet);
  OutputGroup outputs;
  BoundaryWriter writer(output, boundary_options, common, outputs);
  const Options options = engine_options(common, bar);
  Report report;
  with_threads(common.engine, [&] {
    bar.show_part(0, 0.3);
    const Solid solid = unite(read_boxes(input, nullptr, common.volume), options, &report);
    bar.show_part(0.3, 0.8);  // the rest is writing
    writer.write(solid, options, report);
  });
  bar.clear();
  std::vector<Result> results = writer.results();
  add_report(results, report);
  print_results(results, common.json);
  outputs.publish();
}

void generate(const BoxGenerator& generator, const std::string& output, const Common& common) {
  ProgressBar bar(common.quiet);
  OutputGroup outputs;
  OutputFile file = open_output(output, FileUse::boxes, &outputs);
  with_threads(common.engine, [&] {
    BoxWriter<std::int32_t> writer(file, generator.count);
    std::uint64_t done = 0;
    generator.run([&](std::span<const IntegerBox> boxes) {
      writer.write(boxes);
      done += boxes.size();
      bar.show(double(done) / double(generator.count));
    });
    file.commit();
  });
  bar.clear();
  print_results({count_result("boxes", generator.count), string_result("output", output)}, common.json);
  outputs.publish();
}

void generate_volume(const std::function<Volume()>& generator, bool as_voxels, const std::string& output,
                     const Common& common) {
  OutputGroup outputs;
  OutputFile file = open_output(output, as_voxels ? FileUse::voxels : FileUse::boxes, &outputs);
  Result count;
  with_threads(common.engine, [&] {
    const Volume volume = generator();
    if (as_voxels) {
      count = count_result("voxels", volume.grid.voxels());
      write_volume<std::uint8_t>(volume.grid, volume.inside, std::move(file));
    } else {
      const BoxSet boxes = voxel_boxes(stream_of(volume));
      count = count_result("boxes", boxes.size());
      write_boxes(boxes, std::move(file));
    }
  });
  print_results({count, string_result("output", output)}, common.json);
  outputs.publish();
}

void devices(const Common& common) {
  std::vector<std::string> notes;
  const std::vector<DeviceInfo> devices = list_devices(&notes);
  const Tuning tuned{.tuned = tuned_launches()};
  const std::string path = tuning_path();
  std::error_code ignored;
  const std::string tuning_file = std::filesystem::exists(path, ignored) ? path : "";
  std::string out;
  if (common.json) {
    for (const DeviceInfo& d : devices)
      out += fmt::format(
          "{}{{\"id\": {}, \"name\": {}, \"driver\": {}, \"cpu\": {}, \"unified_memory\": {}, "
          "\"memory_bytes\": {}, \"max_buffer_bytes\": {}, \"max_workgroup\": {}, \"launches\": {{{}}}}}",
          out.empty() ? "" : ", ", json_string(d.id), json_string(d.name), json_string(d.driver), d.is_cpu,
          d.is_unified, d.memory_bytes, d.max_buffer_bytes, d.max_workgroup, json_launches(d, tuned));
    std::string note_list;
    for (const std::string& note : notes) note_list += (note_list.empty() ? "" : ", ") + json_string(note);
    print(fmt::format("{{\"devices\": [{}], \"notes\": [{}], \"tuning_file\": {}}}\n", out, note_list,
                      tuning_file.empty() ? "null" : json_string(tuning_file)));
    return;
  }
  std::size_t id_width = 0, name_width = 0;
  for (const DeviceInfo& d : devices) {
    id_width = std::max(id_width, d.id.size());
    name_width = std::max(name_width, d.name.size());
  }
  for (const DeviceInfo& d : devices)
    out += fmt::format("{:{}}  {}  {:6.1f} GiB  {:{}}  {}\n", d.id, id_width, d.is_cpu ? "CPU" : "GPU",
                       double(d.memory_bytes) / double(1 << 30), d.name, name_width, d.driver);
  for (const DeviceInfo& d : devices) out += text_launches(d, tuned);
  if (!tuning_file.empty()) out += fmt::format("tuning file: {}\n", printable(tuning_file));
  for (const std::string& note : notes) out += fmt::format("note: {}\n", note);
  print(out);
}

}  // namespace boxunion::command

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/command/command.hpp"
#include "host/command/command_results.hpp"
#include "host/engine/threads.hpp"
#include "host/external/external_union.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {
namespace {

/// The findings of a run, in memory or not.
struct Measured {
  MassProperties mass;
  std::uint64_t boxes = 0, degenerate = 0;
};

Measured measure_held(const std::string& input, const Common& common, const Options& options,
                      Report& report) {
  const BoxSet boxes = read_boxes(input, nullptr, common.volume);
  return {boxunion::measure(boxes, options, &report), boxes.size(), count_degenerate(boxes)};
}

Measured measure_within_budget(const std::string& input, const Common& common, const Options& options,
                               Report& report, std::optional<std::uint64_t>& slabs) {
  const auto boxes = open_boxes(input, *common.budget, common.volume);
  ExternalUnion external(*boxes, options, *common.budget, report);
  const MassProperties mass = external.measure();
  slabs = external.slabs();
  return {mass, boxes->size(), external.degenerate_boxes()};
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

/// Adds statistics: in JSON as one member, an object.
void add_statistics(std::vector<Result>& results, const Report& report, bool as_json) {
  const std::vector<Result> statistics = statistics_results(report);
  if (!as_json) {
    results.insert(results.end(), statistics.begin(), statistics.end());
    return;
  }
  std::string json;
  for (const Result& result : statistics)
    json += fmt::format("{}{}: {}", json.empty() ? "" : ", ", json_string(result.key), result.json);
  results.push_back({"statistics", "{" + json + "}", ""});
}

}  // namespace

void measure(const std::string& input, const Common& common) {
  ProgressBar bar(common.quiet);
  Report report;
  std::optional<std::uint64_t> slabs;
  const Measured found = with_threads(common.engine, [&] {
    const Options options = engine_options(common, bar);
    return common.budget ? measure_within_budget(input, common, options, report, slabs)
                         : measure_held(input, common, options, report);
  });
  bar.clear();
  std::vector<Result> results = {count_result("boxes", found.boxes),
                                 count_result("degenerate_boxes", found.degenerate)};
  for (const Result& result : mass_results(found.mass)) results.push_back(result);
  if (report.statistics) add_statistics(results, report, common.json);
  finish(results, slabs, report, common);
}

}  // namespace boxunion::command

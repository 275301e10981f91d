#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/adjacency.hpp"
#include "core/components.hpp"
#include "core/decomposition.hpp"
#include "core/error.hpp"
#include "core/evm.hpp"
#include "host/command.hpp"
#include "host/command_results.hpp"
#include "host/command_threads.hpp"
#include "host/files.hpp"
#include "host/stopwatch.hpp"

namespace boxunion::command {
namespace {

/// So that components are numbered in the order of their first points in z, y, x.
constexpr AxisOrder kLabelOrder = {2, 1, 0};

const char* name(Model model) {
  constexpr std::array kNames = {"evm", "oudb", "cudb"};
  return kNames[std::size_t(model)];
}

/// Ends a stage of the work.
class Stages {
 public:
  Stages(Report& report, const Common& common) : watch_(report), common_(common) {}
  void finish(std::string_view stage) {
    watch_.lap(stage);
    if (common_.interrupted && *common_.interrupted) throw Error(ErrorKind::interrupted, "interrupted");
  }
  ~Stages() { watch_.total(); }

 private:
  Stopwatch watch_;
  const Common& common_;
};

/// The extreme vertices in the order asked for, or in that which gives the model the fewest elements (of
/// equals the first; extreme vertices are as many in every order).
Evm ordered_evm(const Solid& solid, Model model, const std::optional<AxisOrder>& order) {
  if (order || model == Model::evm) return make_evm(solid, order.value_or(kAxisOrders[0]));
  const BoxModel boxes = model == Model::oudb ? BoxModel::oudb : BoxModel::cudb;
  Evm best;
  std::uint64_t fewest = 0;
  for (const AxisOrder& candidate : kAxisOrders) {
    Evm evm = make_evm(solid, candidate);
    const std::uint64_t count = count_boxes(evm, boxes);
    if (candidate != kAxisOrders[0] && count >= fewest) continue;
    fewest = count;
    best = std::move(evm);
  }
  return best;
}

}  // namespace

void decompose(const std::string& input, const std::string& output, const DecomposeOptions& decompose_options,
               const Common& common) {
  ProgressBar bar(common.quiet);
  std::optional<OutputFile> file;
  if (!output.empty()) file.emplace(open_output(output, common.interrupted));
  Report report;
  const Model model = decompose_options.model;
  std::vector<Result> results = {string_result("model", name(model))};
  with_threads(common, [&] {
    const Solid solid = unite(read_boxes(input, common.interrupted), engine_options(common, bar), &report);
    Stages stages(report, common);
    const Evm evm = ordered_evm(solid, model, decompose_options.order);
    stages.finish("evm");
    results.push_back(string_result("order", to_string(evm.order)));
    if (model == Model::evm) {
      results.push_back(count_result("vertices", evm.vertices.size()));
      results.push_back(count_result("bytes", evm.vertices.size() * sizeof(evm.vertices[0])));
      if (file) write_extreme_vertices(evm, std::move(*file));
      return;
    }
    const Decomposition boxes = decompose(evm, model == Model::oudb ? BoxModel::oudb : BoxModel::cudb);
    stages.finish("boxes");
    const Adjacency adjacency = find_neighbors(boxes, decompose_options.connectivity);
    stages.finish("neighbors");
    results.push_back(count_result("boxes", boxes.boxes.size()));
    results.push_back(
        count_result("neighbors", adjacency.forward[0].boxes.size() + adjacency.forward[1].boxes.size()));
    results.push_back(count_result("bytes", boxes.boxes.size() * sizeof(OrdinalBox) + adjacency.bytes()));
    if (file) write_boxes(to_boxes(boxes), std::move(*file));
  });
  bar.clear();
  if (!output.empty()) results.push_back(string_result("output", output));
  add_report(results, report);
  print_results(results, common.json);
}

void label(const std::string& input, const std::string& output, const std::string& components,
           Connectivity connectivity, const Common& common) {
  ProgressBar bar(common.quiet);
  std::optional<OutputFile> file, table;
  if (!output.empty()) file.emplace(open_output(output, common.interrupted));
  if (!components.empty()) table.emplace(open_output(components, common.interrupted));
  Report report;
  std::vector<Result> results;
  with_threads(common, [&] {
    const Solid solid = unite(read_boxes(input, common.interrupted), engine_options(common, bar), &report);
    Stages stages(report, common);
    const Decomposition boxes = decompose(make_evm(solid, kLabelOrder), BoxModel::cudb);
    stages.finish("boxes");
    const Adjacency adjacency = find_neighbors(boxes, connectivity);
    stages.finish("neighbors");
    const Labels labels = label_components(adjacency);
    stages.finish("labels");
    results = {count_result("components", labels.count),
               count_result("connectivity", std::uint64_t(connectivity)),
               count_result("boxes", boxes.boxes.size())};
    if (file) write_labelled_boxes(to_boxes(boxes), labels.labels, std::move(*file));
    if (table) write_components(measure_components(boxes, labels), std::move(*table));
  });
  bar.clear();
  if (!output.empty()) results.push_back(string_result("output", output));
  if (!components.empty()) results.push_back(string_result("components_output", components));
  add_report(results, report);
  print_results(results, common.json);
}

}  // namespace boxunion::command

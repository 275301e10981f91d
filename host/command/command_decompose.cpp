#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "core/models/sections.hpp"
#include "host/command/command.hpp"
#include "host/command/command_results.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/engine/threads.hpp"
#include "host/external/external_decomposition.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {
namespace {

const char* name(Model model) {
  constexpr std::array kNames = {"evm", "oudb", "cudb"};
  return kNames[std::size_t(model)];
}

/// The model of disjoint boxes, or none for extreme vertices.
std::optional<BoxModel> box_model(Model model) {
  if (model == Model::evm) return std::nullopt;
  return model == Model::oudb ? BoxModel::oudb : BoxModel::cudb;
}

/// Adds the order, the number of elements and their bytes in memory. If boxes have neighbors, adds their
/// pairs, and the bytes include the neighbor lists.
void add_model(std::vector<Result>& results, std::optional<BoxModel> boxes, const AxisOrder& order,
               std::uint64_t elements, std::optional<Connectivity> connectivity, std::uint64_t pairs) {
  std::uint64_t bytes = elements * (boxes ? sizeof(OrdinalBox) : sizeof(OrderedPoint<3>));
  if (boxes && connectivity) {
    results.push_back(count_result("neighbors", pairs));
    bytes += Adjacency::bytes_of(elements, pairs);
  }
  results.push_back(string_result("order", to_string(order)));
  results.push_back(count_result(boxes ? "boxes" : "vertices", elements));
  results.push_back(count_result("bytes", bytes));
}

/// Makes the model in memory, writes it to `file`, if there is one, and adds its results.
void decompose_held(const Solid& solid, const DecomposeOptions& asked, std::optional<OutputFile> file,
                    std::vector<Result>& results, Report& report) {
  const std::optional<BoxModel> model = box_model(asked.model);
  Stages stages(report);
  const Evm evm = asked.order || !model ? make_evm(solid, asked.order.value_or(kAxisOrders[0]))
                                        : make_evm_of_fewest_boxes(solid, *model);
  stages.finish("evm");
  if (!model) {
    add_model(results, model, evm.order, evm.vertices.size(), {}, 0);
    stages.end();
    if (file) write_extreme_vertices(evm, std::move(*file));
    return;
  }
  const Decomposition boxes = decompose(evm, *model);
  stages.finish("boxes");
  std::uint64_t pairs = 0;
  if (asked.connectivity) {
    pairs = find_neighbors(boxes, *asked.connectivity).pairs();
    stages.finish("neighbors");
  }
  stages.end();
  add_model(results, model, evm.order, boxes.boxes.size(), asked.connectivity, pairs);
  if (file) write_boxes(to_boxes(boxes), std::move(*file));
}

/// The same for a union that does not fit memory.
void decompose_within_budget(ExternalUnion& solid, const DecomposeOptions& asked,
                             std::optional<OutputFile> file, std::vector<Result>& results, Report& report) {
  const std::optional<BoxModel> model = box_model(asked.model);
  const ExternalModel made =
      decompose(solid, model, asked.order, asked.connectivity, std::move(file), report);
  add_model(results, model, made.order, made.elements, asked.connectivity, made.pairs);
}

}  // namespace

void decompose(const std::string& input, const std::string& output, const DecomposeOptions& decompose_options,
               const Common& common) {
  ProgressBar bar(common.quiet);
  OutputGroup outputs;
  std::optional<OutputFile> file;
  if (!output.empty()) file.emplace(open_output(output, FileUse::boxes, &outputs));
  Report report;
  std::vector<Result> results = {string_result("model", name(decompose_options.model))};
  std::optional<std::uint64_t> slabs;
  with_threads(common.engine, [&] {
    const Options options = engine_options(common, bar);
    if (common.budget) {
      const auto boxes = open_boxes(input, *common.budget, common.volume);
      ExternalUnion solid(*boxes, options, *common.budget, report);
      decompose_within_budget(solid, decompose_options, std::move(file), results, report);
      slabs = solid.slabs();
    } else {
      const Solid solid = unite(read_boxes(input, nullptr, common.volume), options, &report);
      decompose_held(solid, decompose_options, std::move(file), results, report);
    }
  });
  bar.clear();
  if (!output.empty()) results.push_back(string_result("output", output));
  finish(results, slabs, report, common);
  outputs.publish();
}

}  // namespace boxunion::command

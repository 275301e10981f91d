#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/adjacency.hpp"
#include "core/decomposition.hpp"
#include "core/error.hpp"
#include "core/evm.hpp"
#include "host/command.hpp"
#include "host/command_results.hpp"
#include "host/files.hpp"
#include "host/stopwatch.hpp"
#include "host/threads.hpp"

namespace boxunion::command {
namespace {

constexpr std::uint64_t kBytesAVertex = 120;  ///< of vertices, extreme vertices and boxes, as measured

const char* name(Model model) {
  constexpr std::array kNames = {"evm", "oudb", "cudb"};
  return kNames[std::size_t(model)];
}

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
  if (common.budget && (decompose_options.model == Model::oudb || decompose_options.connectivity))
    throw Error(ErrorKind::usage,
                "--memory is for the models evm and cudb without --connectivity: nothing bounds the others");
  ProgressBar bar(common.quiet);
  std::optional<OutputFile> file;
  if (!output.empty()) file.emplace(open_output(output, common.interrupted));
  Report report;
  const Model model = decompose_options.model;
  std::vector<Result> results = {string_result("model", name(model))};
  with_threads(common.engine.threads, common.interrupted, [&] {
    const Options options = engine_options(common, bar);
    check_budget(input, "a decomposition", kBytesAVertex, options, common);
    const Solid solid = unite(read_boxes(input, common.interrupted, common.volume), options, &report);
    Stages stages(report, common.interrupted);
    const Evm evm = ordered_evm(solid, model, decompose_options.order);
    stages.finish("evm");
    results.push_back(string_result("order", to_string(evm.order)));
    if (model == Model::evm) {
      results.push_back(count_result("vertices", evm.vertices.size()));
      results.push_back(count_result("bytes", evm.vertices.size() * sizeof(evm.vertices[0])));
      stages.end();
      if (file) write_extreme_vertices(evm, std::move(*file));
      return;
    }
    const Decomposition boxes = decompose(evm, model == Model::oudb ? BoxModel::oudb : BoxModel::cudb);
    stages.finish("boxes");
    std::size_t bytes = boxes.boxes.size() * sizeof(OrdinalBox);
    results.push_back(count_result("boxes", boxes.boxes.size()));
    if (decompose_options.connectivity) {
      const Adjacency adjacency = find_neighbors(boxes, *decompose_options.connectivity);
      stages.finish("neighbors");
      results.push_back(
          count_result("neighbors", adjacency.forward[0].boxes.size() + adjacency.forward[1].boxes.size()));
      bytes += adjacency.bytes();
    }
    stages.end();
    results.push_back(count_result("bytes", bytes));
    if (file) write_boxes(to_boxes(boxes), std::move(*file));
  });
  bar.clear();
  if (!output.empty()) results.push_back(string_result("output", output));
  add_report(results, report);
  print_results(results, common.json);
}

}  // namespace boxunion::command

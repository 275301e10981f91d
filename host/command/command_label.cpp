#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/voxels.hpp"
#include "core/base/memory.hpp"
#include "host/command/command.hpp"
#include "host/command/command_memory.hpp"
#include "host/command/command_results.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/engine/threads.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {
namespace {

/// The files that `label` writes. They are opened before the work that fills them.
struct LabelFiles {
  std::optional<OutputFile> labels, components;
  LabelFiles(const std::string& output, FileUse use, const LabelOptions& label_options,
             OutputGroup& outputs) {
    if (!output.empty()) labels.emplace(open_output(output, use, &outputs));
    if (!label_options.components.empty())
      components.emplace(open_output(label_options.components, FileUse::boxes, &outputs));
  }
};

/// Labels runs of voxels. This needs no union.
std::vector<Result> label_voxels_of(const std::string& input, LabelFiles files, Connectivity connectivity,
                                    const Common& common) {
  const Volume volume = read_volume(input, common.volume);
  Report report;
  Stopwatch watch(report);
  Array<std::uint32_t> labels;
  with_memory("the labels", 4 * volume.inside.size(), [&] { labels.resize(volume.inside.size()); });
  const std::vector<VoxelComponent> components = label_voxels(volume, connectivity, labels);
  watch.total();
  if (files.labels) write_volume<std::uint32_t>(volume.grid, labels, std::move(*files.labels));
  if (files.components)
    write_components(measure_components(volume.grid, components), std::move(*files.components));
  std::uint64_t voxels = 0;
  for (const VoxelComponent& component : components) voxels += component.voxels;
  return {count_result("components", components.size()),
          count_result("connectivity", std::uint64_t(connectivity)), count_result("voxels", voxels),
          seconds_result(report.seconds)};
}

std::vector<Result> label_boxes_of(const std::string& input, LabelFiles files, Connectivity connectivity,
                                   HeldBoxes held, const Common& common, ProgressBar& bar) {
  constexpr AxisOrder kOrder = {2, 1, 0};  // like voxels: numbered by their first points in z, y, x
  Report report;
  const Solid solid = unite(held.read(input), engine_options(common, bar), &report);
  Stages stages(report);
  const Decomposition boxes = decompose(make_evm(solid, kOrder), BoxModel::cudb);
  stages.finish("boxes");
  const Labels labels = label_components(boxes, connectivity);
  stages.finish("labels");
  stages.end();
  if (files.labels) write_labelled_boxes(to_boxes(boxes), labels.labels, std::move(*files.labels));
  if (files.components) write_components(measure_components(boxes, labels), std::move(*files.components));
  std::vector<Result> results = {count_result("components", labels.count),
                                 count_result("connectivity", std::uint64_t(connectivity)),
                                 count_result("boxes", boxes.boxes.size())};
  add_report(results, report);
  return results;
}

}  // namespace

void label(const std::string& input, const std::string& output, const LabelOptions& label_options,
           const Common& common) {
  ProgressBar bar(common.quiet);
  HeldBoxes held(common);
  const bool volume = is_volume(input);
  OutputGroup outputs;
  LabelFiles files(output, volume ? FileUse::voxels : FileUse::boxes, label_options, outputs);
  std::vector<Result> results = with_threads(common.engine, [&] {
    return volume ? label_voxels_of(input, std::move(files), label_options.connectivity, common)
                  : label_boxes_of(input, std::move(files), label_options.connectivity, held, common, bar);
  });
  bar.clear();
  const auto add_file = [&](const char* key, const std::string& path) {
    if (!path.empty()) results.push_back(string_result(key, path));
  };
  add_file("output", output);
  add_file("components_output", label_options.components);
  print_results(results, common.json);
  outputs.publish();
}

}  // namespace boxunion::command

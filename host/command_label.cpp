#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/memory.hpp"
#include "host/command.hpp"
#include "host/command_output.hpp"
#include "host/command_threads.hpp"
#include "host/files.hpp"
#include "host/stopwatch.hpp"

namespace boxunion::command {

void label(const std::string& input, VoxelConnectivity connectivity, const std::string& output,
           const Common& common) {
  std::optional<OutputFile> file;
  if (!output.empty()) file.emplace(open_output(output, common.interrupted, kVoxelFormats));
  std::vector<VoxelComponent> components;
  Report report;
  with_threads(common, [&] {
    const Volume volume = read_volume(input, common.volume, common.interrupted);
    Stopwatch stopwatch(report);
    Array<std::uint32_t> labels;
    with_memory("the labels", 4 * volume.inside.size(), [&] { labels.resize(volume.inside.size()); });
    components = label_voxels(volume, connectivity, labels);
    stopwatch.total("total");
    if (file) write_volume<std::uint32_t>(volume.grid, labels, std::move(*file));
  });

  std::uint64_t voxels = 0, largest = 0;
  for (const VoxelComponent& component : components) {
    voxels += component.voxels;
    largest = std::max(largest, component.voxels);
  }
  std::vector<Result> results = {count_result("components", components.size()),
                                 count_result("voxels", voxels), count_result("largest_component", largest),
                                 count_result("connectivity", std::uint64_t(connectivity))};
  if (file) results.push_back(string_result("output", output));
  results.push_back(seconds_result(report.seconds));
  print_results(results, common.json);
}

}  // namespace boxunion::command

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/command/boundary_writer.hpp"
#include "host/command/command.hpp"
#include "host/command/command_results.hpp"
#include "host/engine/threads.hpp"
#include "host/external/external_union.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {

void boundary(const std::string& input, const std::string& output, const BoundaryOptions& boundary_options,
              const Common& common) {
  ProgressBar bar(common.quiet);
  OutputGroup outputs;
  BoundaryWriter writer(output, boundary_options, common, outputs);
  Report report;
  std::optional<std::uint64_t> slabs;
  with_threads(common.engine, [&] {
    const Options options = engine_options(common, bar);
    if (common.budget) {
      const auto boxes = open_boxes(input, *common.budget, common.volume);
      ExternalUnion solid(*boxes, options, *common.budget, report);
      writer.write(solid, report);
      slabs = solid.slabs();
    } else {
      bar.show_part(0, 0.3);
      const Solid solid = unite(read_boxes(input, nullptr, common.volume), options, &report);
      bar.show_part(0.3, 0.8);  // writing is the rest
      writer.write(solid, options, report);
    }
  });
  bar.clear();
  std::vector<Result> results = writer.results();
  finish(results, slabs, report, common);
  outputs.publish();
}

}  // namespace boxunion::command

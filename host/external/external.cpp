#include "boxunion/external.hpp"

#include <utility>

#include "host/engine/threads.hpp"
#include "host/external/external_boundary.hpp"
#include "host/external/external_decomposition.hpp"
#include "host/external/external_union.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"

namespace boxunion {
namespace {

/// Runs f(union, report) for the boxes of a file, on the number of threads in the options.
template <class F>
auto with_union(const std::string& input, const Budget& budget, const Options& options,
                const VolumeOptions& volume, ExternalReport* report, F&& f) {
  ExternalReport ignored;
  ExternalReport& filled = report ? *report : ignored;
  return with_threads(options, [&] {
    const auto boxes = open_boxes(input, budget, volume);
    ExternalUnion solid(*boxes, options, budget, filled.engine);
    auto result = f(solid, filled.engine);
    filled.boxes = boxes->size();
    filled.degenerate_boxes = solid.degenerate_boxes();
    filled.slabs = solid.slabs();
    return result;
  });
}

}  // namespace

MassProperties measure_file(const std::string& input, const Budget& budget, const Options& options,
                            const VolumeOptions& volume, ExternalReport* report) {
  return with_union(input, budget, options, volume, report,
                    [](ExternalUnion& solid, Report&) { return solid.measure(); });
}

BoundaryCounts write_boundary(const std::string& input, const std::string& output, const Budget& budget,
                              NonManifold contacts, bool triangles_only, const Options& options,
                              const VolumeOptions& volume, ExternalReport* report) {
  OutputFile file = open_output(output, FileUse::mesh);
  return with_union(input, budget, options, volume, report, [&](ExternalUnion& solid, Report& engine) {
    return write_boundary(solid, contacts, triangles_only, std::move(file), engine).counts;
  });
}

std::uint64_t write_decomposition(const std::string& input, const std::string& output, const Budget& budget,
                                  std::optional<BoxModel> model, const std::optional<AxisOrder>& order,
                                  const Options& options, const VolumeOptions& volume,
                                  ExternalReport* report) {
  OutputFile file = open_output(output);
  return with_union(input, budget, options, volume, report, [&](ExternalUnion& solid, Report& engine) {
    return decompose(solid, model, order, {}, std::move(file), engine).elements;
  });
}

}  // namespace boxunion

// One case of bench/families in a process of its own: a family of boxes in some order, and a model of its
// union. Prints JSON: boxes, vertices and boxes of the result, the least wall and processor seconds of as
// many runs as fit a time limit (at least one), and the peak memory of the process after the first run.

#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include "bench/timing.hpp"
#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/union.hpp"
#include "tests/support/families.hpp"

namespace boxunion {
namespace {

/// The size of a result.
struct Output {
  std::uint64_t vertices = 0, boxes = 0;
};

Output run_measure(const BoxSet& boxes) {
  return {measure(boxes, {.device = "native"}).vertices, 0};
}

Output run_boundary(const BoxSet& boxes) {
  const Options options{.device = "native"};
  const Solid solid = unite(boxes, options);
  find_boundary(solid, NonManifold::keep, options);
  return {solid.vertices.size(), 0};
}

Output run_decompose(const BoxSet& boxes) {
  const Solid solid = unite(boxes, {.device = "native"});
  const Decomposition disjoint = decompose(make_evm(solid, {0, 1, 2}), BoxModel::cudb);
  return {solid.vertices.size(), disjoint.boxes.size()};
}

Output run_label(const BoxSet& boxes) {
  const Solid solid = unite(boxes, {.device = "native"});
  const Decomposition disjoint = decompose(make_evm(solid, {2, 1, 0}), BoxModel::cudb);
  label_components(disjoint, Connectivity::faces);
  return {solid.vertices.size(), disjoint.boxes.size()};
}

using Work = Output (*)(const BoxSet&);
const std::map<std::string, Work> kWorks = {
    {"measure", run_measure}, {"boundary", run_boundary}, {"decompose", run_decompose}, {"label", run_label}};

/// The peak memory of this program, without that of the process before it became this program.
std::uint64_t peak_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::stoull(line.substr(6));
  throw std::runtime_error("/proc/self/status has no VmHWM");
}

/// Processor seconds of all threads so far.
double cpu_seconds() {
  rusage usage;
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void run(const Family& family, std::size_t size, RowOrder order, Work work, double turn) {
  const BoxSet boxes = reorder(family.make(size), order);
  Output output;
  double seconds = 0, cpu = 0, sum = 0;
  std::uint64_t peak = 0;
  do {
    const double cpu_before = cpu_seconds();
    const double now = seconds_of([&] { output = work(boxes); });
    const double cpu_now = cpu_seconds() - cpu_before;
    if (peak == 0) {
      peak = peak_bytes();
      seconds = now, cpu = cpu_now;
    }
    seconds = std::min(seconds, now);
    cpu = std::min(cpu, cpu_now);
    sum += now;
  } while (sum < turn);
  fmt::print(
      R"({{"boxes": {}, "vertices": {}, "output_boxes": {}, "seconds": {:.6g}, "cpu": {:.6g}, "peak_bytes": {}}})"
      "\n",
      boxes.size(), output.vertices, output.boxes, seconds, cpu, peak);
}

const Family& find_family(const std::string& name) {
  for (const Family& family : families())
    if (family.name == name) return family;
  throw std::runtime_error("no family " + name);
}

int run_command(int argc, char** argv) {
  CLI::App app("One case of bench/families");
  std::string family, work;
  std::size_t size = 0;
  RowOrder order = RowOrder::given;
  bool list = false;
  double turn = 0;
  app.add_flag("--list", list, "Print the names of the families and what they are");
  app.add_option("family", family);
  app.add_option("size", size, "About how many boxes")->check(CLI::Range(1, 100'000'000));
  std::map<std::string, RowOrder> orders;
  for (const RowOrder o : kRowOrders) orders[name(o)] = o;
  app.add_option("order", order)->transform(CLI::CheckedTransformer(orders));
  app.add_option("work", work)->check(CLI::IsMember(kWorks));
  app.add_option("--repeat", turn, "Seconds for which runs are repeated")->type_name("SECONDS");
  CLI11_PARSE(app, argc, argv);
  if (list)
    for (const Family& f : families()) fmt::print("{} {}\n", f.name, f.what);
  else
    run(find_family(family), size, order, kWorks.at(work), turn);
  return 0;
}

}  // namespace
}  // namespace boxunion

int main(int argc, char** argv) try {
  return boxunion::run_command(argc, argv);
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}

#include "host/command/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <map>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "host/command/command.hpp"
#include "host/command/command_help.hpp"
#include "host/command/command_numbers.hpp"
#include "host/command/command_options.hpp"
#include "host/command/command_output.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {
namespace {

std::string boundary_output() {
  return fmt::format("File to write: vertices as {}, a mesh as {}", extensions(FileUse::boxes),
                     extensions(FileUse::mesh));
}

/// The command line: the options of each subcommand, and the function that it calls.
class CommandLine : CommonOptions {
 public:
  CommandLine() : app_("The exact union of any number of axis-aligned boxes, on any device.", "boxunion") {
    app_.set_version_flag("--version", "boxunion " BOXUNION_VERSION);
    app_.require_subcommand(1);
    add_measure();
    add_boundary();
    add_decompose();
    add_label();
    add_combine();
    add_generate();
    add_devices();
    add_bench();
    // last, because subcommands inherit an earlier footer
    app_.footer(fmt::format(kExamples, extensions(FileUse::volume)));
  }

  /// The budget of --memory, in bytes; 0 if there is none.
  std::uint64_t memory() const { return memory_; }

  /// Runs the subcommand in the arguments.
  void run(int argc, const char* const* argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::Success& help) {
      std::ostringstream text;
      app_.exit(help, text);
      print(text.str());
    }
  }

 private:
  void add_measure() {
    CLI::App* sub =
        app_.add_subcommand("measure", "Mass properties: volume, area, edge length, centroid, ...");
    add_input(sub);
    add_engine_options(sub);
    sub->add_flag(
        "--statistics", common_.engine.statistics,
        "Also print what the cells did, sums over the boxes, and the number of vertices of each kind");
    add_print_options(sub);
    add_memory(sub);
    sub->callback([this] { command::measure(input_, with_budget()); });
  }

  void add_boundary() {
    CLI::App* sub = app_.add_subcommand("boundary", "The boundary of the union: its vertices, or a mesh");
    add_input(sub);
    add_boundary_options(sub, add_output(sub, boundary_output()));
    add_engine_options(sub);
    add_print_options(sub);
    add_memory(sub);
    sub->callback([this] { boundary(input_, output_, boundary_, with_budget()); });
  }

  void add_decompose() {
    CLI::App* sub =
        app_.add_subcommand("decompose", "The union as disjoint boxes, or as its extreme vertices");
    add_input(sub, "--vox-model");
    add_output(sub)->required(false);
    add_choice(sub, "--model", decompose_.model,
               {{"evm", Model::evm}, {"oudb", Model::oudb}, {"cudb", Model::cudb}},
               "evm: extreme vertices; oudb: boxes cut at every plane and line of vertices; cudb (default): "
               "oudb with equal neighbors merged");
    std::map<std::string, std::optional<AxisOrder>> orders = {{"best", std::nullopt}};
    for (const AxisOrder& order : kAxisOrders) orders[to_string(order)] = order;
    add_choice(sub, "--order", decompose_.order, orders,
               "Axes in the order of cutting and sorting: xyz (default), ..., or best: the order with the "
               "fewest boxes");
    add_connectivity(sub, decompose_.connectivity, "Find the neighbors of each box and count them");
    add_engine_options(sub);
    add_print_options(sub);
    add_memory(sub);
    sub->callback([this] { decompose(input_, output_, decompose_, with_budget()); });
  }

  void add_label() {
    CLI::App* sub = app_.add_subcommand("label", "The connected components of the union");
    add_input(sub);
    add_output(sub, fmt::format("File to write: for boxes, disjoint boxes with labels as {}; for a volume, a "
                                "volume of labels as {}, 0 outside",
                                extensions(FileUse::boxes), extensions(FileUse::voxels)))
        ->required(false);
    sub->add_option("--components", label_.components,
                    "File for a table of the components: " + extensions(FileUse::boxes));
    add_connectivity(sub, label_.connectivity, "What counts as connected (default: 6)");
    add_engine_options(sub);
    add_print_options(sub);
    add_memory(sub);
    sub->callback([this] { label(input_, output_, label_, with_budget()); });
  }

  void add_combine() {
    CLI::App* sub =
        app_.add_subcommand("combine", "Boolean expressions over sets of boxes: mass properties, boundary");
    sub->add_option("EXPRESSION", expression_, "For example \"A and (B or C) not D\"; see below")->required();
    sub->add_option("NAME=FILE", sets_,
                    "Boxes or voxels of each set, as FILE of measure; options for voxels apply to all sets")
        ->required();
    add_volume_options(sub);
    add_boundary_options(sub, add_output(sub, boundary_output())->required(false));
    sub->add_option(
        "--boxes", boxes_,
        fmt::format("File for the result as disjoint boxes: {} (see decompose)", extensions(FileUse::boxes)));
    add_engine_options(sub);
    add_print_options(sub);
    add_memory(sub);
    sub->footer(kExpressions);
    sub->callback([this] { combine(expression_, sets_, output_, boxes_, boundary_, with_budget()); });
  }

  void add_generate() {
    CLI::App* sub =
        app_.add_subcommand("generate", "Boxes for tests and benchmarks, the same on every machine");
    sub->require_subcommand(1);

    CLI::App* cubes = sub->add_subcommand("cubes", "Cubes of one edge at random integer positions");
    cubes->add_option("--count", count_, "Number of cubes")->required()->transform(whole_number());
    cubes->add_option("--edge", edge_, "Edge of the cubes")->required()->transform(length());
    add_random_options(cubes);
    add_generator(cubes, [this] { return generate_cubes(count_, edge_, universe_, seed_); });

    CLI::App* boxes = sub->add_subcommand("boxes", "Boxes of random integer edges at random positions");
    boxes->add_option("--count", count_, "Number of boxes")->required()->transform(whole_number());
    boxes->add_option("--min-edge", min_edge_, "Shortest edge")->capture_default_str()->transform(length());
    boxes->add_option("--max-edge", edge_, "Longest edge")->required()->transform(length());
    add_random_options(boxes);
    add_generator(boxes, [this] { return generate_boxes(count_, min_edge_, edge_, universe_, seed_); });

    CLI::App* checkerboard = sub->add_subcommand("checkerboard", "Every other unit cube of a grid");
    checkerboard->add_option("--size", size_, "Cubes along an edge of the grid")
        ->required()
        ->transform(length());
    add_generator(checkerboard, [this] { return generate_checkerboard(size_); });

    CLI::App* sponge = sub->add_subcommand("sponge", "The unit cubes of a Menger sponge");
    sponge->add_option("--level", level_, "Level: 20^level cubes in a grid of 3^level")
        ->required()
        ->transform(length());
    add_generator(sponge, [this] { return generate_sponge(level_); });

    CLI::App* phantom =
        sub->add_subcommand("phantom", "A volume: the 3-D Shepp-Logan phantom, bodies in a shell");
    add_volume_generator(phantom, [this] { return generate_phantom(volume_size()); });

    CLI::App* porous = sub->add_subcommand("porous",
                                           "A volume: a block of random pores (a stone: --size 159 271 179 "
                                           "--porosity 0.4 --feature 7; sparse grains: --porosity 0.98)");
    porous->add_option("--porosity", porosity_.pores, "Fraction of the volume taken by pores, 0 to 1")
        ->capture_default_str()
        ->transform(finite_number());
    porous->add_option("--feature", porosity_.feature, "Width of pores and walls in voxels, 1 to 255")
        ->capture_default_str()
        ->transform(length());
    add_seed(porous);
    add_volume_generator(porous, [this] { return generate_porous(volume_size(), porosity_, seed_); });
  }

  void add_devices() {
    CLI::App* sub = app_.add_subcommand("devices", "The devices of this machine");
    sub->add_flag(
        "--check", check_devices_,
        "Try every kernel on every device on small cases with known results. Takes seconds. The exit status "
        "is 4 if a result is wrong");
    add_print_options(sub);
    sub->callback([this] { check_devices_ ? check_devices(common_) : devices(common_); });
  }

  void add_bench() {
    CLI::App* sub = app_.add_subcommand(
        "bench", "Benchmark the kernels on the devices of this machine, and choose the fastest launches");
    KernelBenchOptions& cases = bench_.cases;
    add_list(sub, "--device", cases.devices, "Devices (default: all); see boxunion devices");
    add_list(sub, "--kernel", cases.kernels, "Kernels (default: all)")
        ->check(
            CLI::IsMember(std::vector<std::string>(benchmark_kernels().begin(), benchmark_kernels().end())));
    add_choices(sub, "--density", cases.densities,
                {{"sparse", Density::sparse}, {"middle", Density::middle}, {"dense", Density::dense}},
                "How full the cells are: the volumes of the cubes add up to 0.015, 0.5 or 3 times the space "
                "(default: all)");
    add_list(sub, "--size", cases.sizes,
             "Approximate number of cells (default: 4096, on GPUs 65536; with --quick 1024)")
        ->transform(whole_number(1, 1 << 20));
    add_choices(sub, "--shape", cases.shapes, {{"group", Shape::group}, {"item", Shape::item}},
                "How a kernel shares its work (default: as in use)");
    add_list(sub, "--workgroup", cases.workgroups, "Work-items of a workgroup (default: as in use)")
        ->transform(whole_number(1, 1024));
    sub->add_option("--repetitions", cases.repetitions, "Timed runs of a case")
        ->transform(whole_number(1, 100'000))
        ->capture_default_str();
    sub->add_flag("--quick", bench_.quick, "Few small cases and few runs, unless other options ask for more");
    CLI::Option* json =
        sub->add_option("--json", bench_.json, "File for the results, in the schema of Google Benchmark");
    CLI::Option* tune = sub->add_option_function<std::string>(
                               "--tune", [this](const std::string& file) { bench_.tune = file; },
                               "Run every shape and workgroup that may be fast, and write the best ones to "
                               "FILE (default: the tuning file in use), from which all commands read them")
                            ->type_name("[FILE]")
                            ->expected(0, 1);
    sub->add_option("--compare", bench_.compare, "Run nothing; show what changed between two result files")
        ->type_name("OLD NEW")
        ->expected(2)
        ->excludes(json)
        ->excludes(tune);
    add_threads(sub);
    sub->footer(kBench);
    sub->callback([this] { bench(bench_, common_); });
  }

  void add_random_options(CLI::App* sub) {
    sub->add_option("--universe", universe_, "Edge of the cube that holds all boxes")
        ->capture_default_str()
        ->transform(length());
    add_seed(sub);
  }

  void add_seed(CLI::App* sub) {
    sub->add_option("--seed", seed_, "Seed of the random numbers")
        ->capture_default_str()
        ->transform(whole_number());
  }

  template <class MakeGenerator>
  void add_generator(CLI::App* sub, MakeGenerator make) {
    add_output(sub);
    add_threads(sub);
    add_print_options(sub);
    sub->callback([this, make] { generate(make(), output_, common_); });
  }

  template <class MakeVolume>
  void add_volume_generator(CLI::App* sub, MakeVolume make) {
    sub->add_option("--size", extents_, "Voxels along each axis: one number, or three for x, y and z")
        ->required()
        ->expected(1, 3)
        ->transform(length());
    sub->add_flag("--volume", as_voxels_,
                  fmt::format("Write the voxels ({} of uint8, shape (z, y, x)) instead of their boxes",
                              extensions(FileUse::voxels)));
    add_output(sub);
    add_threads(sub);
    add_print_options(sub);
    sub->callback([this, make] { generate_volume(make, as_voxels_, output_, common_); });
  }

  std::array<std::int64_t, 3> volume_size() const {
    if (extents_.size() == 2) throw Error(ErrorKind::usage, "--size has two numbers, expected one or three");
    return {extents_.front(), extents_[extents_.size() / 2], extents_.back()};
  }

  CLI::App app_;
  DecomposeOptions decompose_;
  LabelOptions label_;
  BenchOptions bench_;
  std::string boxes_, expression_;
  std::vector<std::string> sets_;
  std::uint64_t count_ = 0, seed_ = 1;
  std::int64_t edge_ = 0, min_edge_ = 1, universe_ = 32768, size_ = 0;
  int level_ = 0;
  std::vector<std::int64_t> extents_;
  Porosity porosity_;
  bool as_voxels_ = false, check_devices_ = false;
};

}  // namespace

void run_command_line(int argc, const char* const* argv) {
  CommandLine line;
  const auto out_of_memory = [&] {
    const std::uint64_t budget = line.memory();
    return Error(ErrorKind::resources,
                 budget == 0 ? "out of memory"
                             : fmt::format("out of memory: this needs more than the {} MiB of --memory",
                                           budget >> 20));
  };
  try {
    line.run(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorKind::usage, error.what());
  } catch (const std::bad_alloc&) {
    throw out_of_memory();
  } catch (const std::length_error&) {
    throw out_of_memory();
  }
}

}  // namespace boxunion::command

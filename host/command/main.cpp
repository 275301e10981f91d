#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <exception>
#include <limits>
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
#include "core/base/interruptible.hpp"
#include "host/command/command.hpp"
#include "host/command/command_memory.hpp"
#include "host/command/command_numbers.hpp"
#include "host/command/command_output.hpp"
#include "host/device/backend.hpp"
#include "host/files/files.hpp"
#include "host/files/scratch.hpp"

namespace {

using namespace boxunion;
using command::byte_count;
using command::finite_number;
using command::whole_number;

constexpr const char* kExamples = R"(
Examples:
  boxunion generate cubes --count 1000000 --edge 48 -o cubes.npy
  boxunion measure cubes.npy
  boxunion measure --json --device native - < boxes.csv
  boxunion boundary boxes.csv -o vertices.csv
  boxunion boundary boxes.csv -o boxes.3mf
  boxunion decompose boxes.csv --order best -o disjoint.csv
  boxunion label boxes.csv -o labelled.npy
  boxunion combine "A and B not C" A=a.csv B=b.npy C=c.csv
  boxunion boundary scan.tif --threshold 90 -o scan.stl
  boxunion label scan.nrrd --connectivity 26 -o labels.npy --components components.csv
  boxunion bench --quick

Boxes are read from .csv (lines xmin,ymin,zmin,xmax,ymax,zmax with an optional header) or .npy (an array of
shape (n, 6) of float64, float32, int32 or int64). Volumes of voxels are read from {}
(.npy: an array of shape (z, y, x)). Each voxel inside is a box.
Whole numbers may have an exponent (1e6). Sizes may have a unit (512M, 1.5G, 2GiB).

Exit status: 0 done, 2 wrong usage, 3 bad input, 4 device missing or failed, 5 out of memory, disk or limits,
130 interrupted.)";

constexpr const char* kExpressions = R"(
Operations, tightest first. Operations of equal rank go from left to right:
  A and B   A & B   in both
  A not B   A - B   in A but not in B; also "A minus B", "A and not B"
  A xor B   A ^ B   in exactly one of them
  A or B    A | B   in at least one of them
Names consist of letters, digits and _. Each set stands for the union of its boxes. Parts of the result without
thickness are left out. The method slices and the kernel faces find unions only.

Examples:
  boxunion combine "A not B" A=block.csv B=holes.npy --json
  boxunion combine "metal and (via1 or via2) not cut" metal=m.npy via1=a.npy via2=b.npy cut=c.csv -o out.stl)";

constexpr const char* kBench = R"(
Every case is checked against the native device and then timed. Device time is the time of the kernel as the
device measures it, or CPU time on the native device. Wall time is from the batch in host memory to the result in
host memory. The first run includes the time to compile the kernel, unless the driver or this process has compiled
it before. Spreads are half the distance between the quartiles. Rates are per second of device time. "of copy" is
the fraction of the bandwidth of a copy on that device.

BOXUNION_TUNING names the tuning file in use; if it is empty, none is used. If it is not set,
$XDG_CONFIG_HOME/boxunion/tuning.json or ~/.config/boxunion/tuning.json is read.

Examples:
  boxunion bench --quick
  boxunion bench --device opencl,vulkan --kernel contour --shape item --workgroup 8,16,32 --json new.json
  boxunion bench --compare old.json new.json
  boxunion bench --tune)";

std::string boundary_output() {
  return fmt::format("File to write: vertices as {}, a mesh as {}", extensions(FileUse::boxes),
                     extensions(FileUse::mesh));
}

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "the signal handler sets it");

/// The first signal asks the work to stop and clean up; one that comes more than a second later kills.
/// (timeout(1) sends its signal twice at once.)
void stop(int signal) {
  static std::atomic<std::time_t> first = 0;
  const std::time_t now = std::time(nullptr);
  if (interrupted && now > first + 1) {
    ::signal(signal, SIG_DFL);
    ::raise(signal);
  }
  if (!interrupted) first = now;
  interrupted = true;
}

/// Handles the signals that ask to stop, except those that were ignored when this process started, as nohup
/// does.
void handle_signals() {
  struct sigaction action = {}, inherited;
  action.sa_sigaction = [](int signal, siginfo_t* info, void*) {
    // Our own write to a closed pipe, or beyond the size limit of files, also fails with an error that says
    // more than the signal.
    const bool is_by_write = (signal == SIGPIPE || signal == SIGXFSZ) && info->si_pid == ::getpid();
    if (!is_by_write) stop(signal);
  };
  action.sa_flags = SA_SIGINFO;
  constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ};
  sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) sigaddset(&action.sa_mask, signal);
  for (const int signal : kSignals)
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler != SIG_IGN)
      sigaction(signal, &action, nullptr);
}

/// Opens standard streams that are closed, so that no file gets their numbers. Reads from them and writes to
/// them still fail.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0)  // this is the lowest free number
      if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream)
        std::_Exit(int(ErrorKind::resources));
}

/// Prints an error on one line and returns the exit status.
int fail(int status, const std::string& message) {
  std::fprintf(stderr, "boxunion: error: %s\n", command::printable(message).c_str());
  return status;
}
int fail(ErrorKind kind, const std::string& message) {
  return fail(int(kind), message);
}

/// The command line: the options of each subcommand, and the function that it calls.
class CommandLine {
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

  int run(int argc, const char* const* argv) {
    try {
      parse(argc, argv);
      return 0;
    } catch (const CLI::ParseError& error) {
      return fail(ErrorKind::usage, error.what());
    } catch (const Error& error) {
      return fail(error.kind(), error.what());
    } catch (const std::bad_alloc&) {
      return fail_for_memory();
    } catch (const std::length_error&) {
      return fail_for_memory();
    } catch (const std::exception& error) {
      if (std::string_view(error.what())
              .starts_with("pthread_create"))  // from oneTBB, if the system refuses threads
        return fail(ErrorKind::resources, error.what());
      return fail(1, fmt::format("internal error: {}", error.what()));
    }
  }

 private:
  void parse(int argc, const char* const* argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::Success& help) {
      std::ostringstream text;
      app_.exit(help, text);
      command::print(text.str());
    }
  }

  int fail_for_memory() const {
    return fail(ErrorKind::resources,
                memory_ == 0 ? "out of memory"
                             : fmt::format("out of memory: this needs more than the {} MiB of --memory",
                                           memory_ >> 20));
  }

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
    sub->callback([this] { command::boundary(input_, output_, boundary_, with_budget()); });
  }

  void add_decompose() {
    CLI::App* sub =
        app_.add_subcommand("decompose", "The union as disjoint boxes, or as its extreme vertices");
    add_input(sub, "--vox-model");
    add_output(sub)->required(false);
    add_choice(sub, "--model", decompose_.model,
               {{"evm", command::Model::evm}, {"oudb", command::Model::oudb}, {"cudb", command::Model::cudb}},
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
    sub->callback([this] { command::decompose(input_, output_, decompose_, with_budget()); });
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
    sub->callback([this] { command::label(input_, output_, label_, with_budget()); });
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
    sub->callback(
        [this] { command::combine(expression_, sets_, output_, boxes_, boundary_, with_budget()); });
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
    sub->callback([this] { check_devices_ ? command::check_devices(common_) : command::devices(common_); });
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
    sub->callback([this] { command::bench(bench_, common_); });
  }

  /// An option that may be given several times, or with several values separated by commas.
  template <class T>
  static CLI::Option* add_list(CLI::App* sub, const std::string& name, std::vector<T>& values,
                               const std::string& help) {
    return sub->add_option(name, values, help)->delimiter(',')->allow_extra_args(false);
  }

  /// The same for an option whose values are words from a fixed set.
  template <class T>
  static void add_choices(CLI::App* sub, const std::string& name, std::vector<T>& values,
                          const std::map<std::string, T>& choices, const std::string& help) {
    std::vector<std::string> words;
    words.reserve(choices.size());
    for (const auto& choice : choices) words.push_back(choice.first);
    sub->add_option_function<std::vector<std::string>>(
           name,
           [&values, choices](const std::vector<std::string>& chosen) {
             for (const std::string& word : chosen) values.push_back(choices.at(word));
           },
           help)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(words));
  }

  void add_input(CLI::App* sub, const std::string& model_option = "--model") {
    sub->add_option("FILE", input_,
                    fmt::format("Boxes: {}, or - for CSV on standard input; voxels: {}",
                                extensions(FileUse::boxes), extensions(FileUse::volume)))
        ->required();
    add_volume_options(sub, model_option);
  }

  void add_volume_options(CLI::App* sub, const std::string& model_name = "--model") {
    sub->add_option("--threshold", common_.volume.threshold,
                    "Voxels of at least this value are inside (default: all that are not 0)")
        ->transform(finite_number());
    sub->add_option(
           model_name, common_.volume.model,
           fmt::format("Read only this model of a {} file, counted from 1 (default: all, as the scene places "
                       "them)",
                       extensions(FileUse::scene)))
        ->transform(whole_number(1, std::numeric_limits<std::uint32_t>::max()));
  }

  CLI::Option* add_output(CLI::App* sub,
                          const std::string& help = "File to write: " + extensions(FileUse::boxes)) {
    return sub->add_option("-o,--output", output_, help)->required();
  }

  void add_boundary_options(CLI::App* sub, CLI::Option* output) {
    sub->add_flag("--triangles", boundary_.triangles, "Write triangles where the format (.obj) has polygons")
        ->needs(output);
    add_choice<std::optional<NonManifold>>(
        sub, "--nonmanifold", boundary_.nonmanifold,
        {{"keep", NonManifold::keep}, {"split", NonManifold::split}},
        fmt::format("Edges with four faces and vertices where corners touch: keep them, or "
                    "split them into copies so that the mesh is a manifold (default: "
                    "split for {}, otherwise keep)",
                    extensions(FileUse::manifold, " and ")))
        ->needs(output);
  }

  template <class T>
  static void add_connectivity(CLI::App* sub, T& value, const std::string& help) {
    add_choice<T>(sub, "--connectivity", value, {{"6", Connectivity::faces}, {"26", Connectivity::points}},
                  help + ": 6 for parts that share area, 26 for parts that share any point");
  }

  void add_threads(CLI::App* sub) {
    sub->add_option("--threads", common_.engine.threads, "Threads of the host; 0: one per core")
        ->transform(whole_number(0, 4096))
        ->capture_default_str();
  }

  void add_engine_options(CLI::App* sub) {
    add_choice(sub, "--method", common_.engine.method,
               {{"auto", Method::automatic}, {"cells", Method::cells}, {"slices", Method::slices}},
               "How the union is computed: cells, slices, or auto (default), which suits the boxes");
    add_choice(sub, "--kernel", common_.engine.kernel,
               {{"occupancy", CellKernel::occupancy}, {"faces", CellKernel::faces}},
               "What computes a cell: occupancy (default) or faces");
    sub->add_option("--cell", common_.engine.tuning.cell,
                    "Edge of a cell in ordinals, rounded up to a power of two; 0 (default): by estimate")
        ->transform(whole_number(0, 1 << 19));
    sub->add_option("--device", common_.engine.device, device_choices() + "; see boxunion devices")
        ->capture_default_str();
    sub->add_flag(
        "--no-fallback{false}", common_.engine.fallback,
        "End with exit status 4 if the device fails, instead of continuing natively with a warning");
    add_threads(sub);
    add_choice<std::optional<Shape>>(
        sub, "--shape", common_.engine.tuning.shape, {{"group", Shape::group}, {"item", Shape::item}},
        "How a kernel shares its work: group, a workgroup for each unit of work, or item, a work-item for "
        "each (default: what suits the device)");
    sub->add_option("--workgroup", common_.engine.tuning.workgroup,
                    "Work-items of a workgroup; 0 (default): what suits the device")
        ->transform(whole_number(0, 1024));
  }

  void add_memory(CLI::App* sub) {
    CLI::Option* memory =
        sub->add_option("--memory", memory_,
                        "Limit of memory, for example 2G or 512M. Boxes that do not fit are cut into slabs "
                        "on disk; the "
                        "result is the same. label and combine hold all boxes, or end with exit status 5")
            ->type_name("SIZE")
            ->transform(byte_count());
    sub->add_option("--scratch", scratch_, "Folder for temporary files (default: $TMPDIR or /tmp)")
        ->needs(memory);
  }

  command::Common with_budget() const {
    command::Common common = common_;
    if (memory_ == 0) return common;
    common.budget = Budget{memory_, scratch_.empty() ? default_scratch_folder() : scratch_};
    command::limit_memory(memory_, common.engine);
    return common;
  }

  /// An option whose value is a word from a fixed set.
  template <class T>
  static CLI::Option* add_choice(CLI::App* sub, const std::string& name, T& value,
                                 const std::map<std::string, T>& choices, const std::string& help) {
    std::vector<std::string> words;
    words.reserve(choices.size());
    for (const auto& choice : choices) words.push_back(choice.first);
    return sub
        ->add_option_function<std::string>(
            name, [&value, choices](const std::string& word) { value = choices.at(word); }, help)
        ->check(CLI::IsMember(words));
  }

  void add_print_options(CLI::App* sub) {
    sub->add_flag("--json", common_.json, "Print one JSON object (an infinite number is null)");
    sub->add_flag("--quiet", common_.quiet, "Show no progress");
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

  /// A number of units or voxels. The function that takes it checks the range.
  static CLI::Validator length() {
    return whole_number(0, std::numeric_limits<std::int32_t>::max()).description("");
  }

  template <class MakeGenerator>
  void add_generator(CLI::App* sub, MakeGenerator make) {
    add_output(sub);
    add_threads(sub);
    add_print_options(sub);
    sub->callback([this, make] { command::generate(make(), output_, common_); });
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
    sub->callback([this, make] { command::generate_volume(make, as_voxels_, output_, common_); });
  }

  std::array<std::int64_t, 3> volume_size() const {
    if (extents_.size() == 2) throw Error(ErrorKind::usage, "--size has two numbers, expected one or three");
    return {extents_.front(), extents_[extents_.size() / 2], extents_.back()};
  }

  CLI::App app_;
  command::Common common_;
  command::BoundaryOptions boundary_;
  command::DecomposeOptions decompose_;
  command::LabelOptions label_;
  command::BenchOptions bench_;
  std::string input_, output_, boxes_, expression_;
  std::vector<std::string> sets_;
  std::uint64_t memory_ = 0;
  std::string scratch_;
  std::uint64_t count_ = 0, seed_ = 1;
  std::int64_t edge_ = 0, min_edge_ = 1, universe_ = 32768, size_ = 0;
  int level_ = 0;
  std::vector<std::int64_t> extents_;
  Porosity porosity_;
  bool as_voxels_ = false, check_devices_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  handle_signals();
  const Interruptible scope(&interrupted);
  return CommandLine().run(argc, argv);
}

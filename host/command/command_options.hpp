#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/command/command.hpp"
#include "host/command/command_memory.hpp"
#include "host/command/command_numbers.hpp"
#include "host/device/backend.hpp"
#include "host/files/files.hpp"
#include "host/files/scratch.hpp"

namespace boxunion::command {

/// Options that several subcommands share, and their values.
class CommonOptions {
 protected:
  /// An option that may be given several times, or with several values separated by commas.
  template <class T>
  static CLI::Option* add_list(CLI::App* sub, const std::string& name, std::vector<T>& values,
                               const std::string& help) {
    return sub->add_option(name, values, help)->delimiter(',')->allow_extra_args(false);
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

  Common with_budget() const {
    Common common = common_;
    if (memory_ == 0) return common;
    common.budget = Budget{memory_, scratch_.empty() ? default_scratch_folder() : scratch_};
    limit_memory(memory_, common.engine);
    return common;
  }

  void add_print_options(CLI::App* sub) {
    sub->add_flag("--json", common_.json, "Print one JSON object (an infinite number is null)");
    sub->add_flag("--quiet", common_.quiet, "Show no progress");
  }

  /// A number of units or voxels. The function that takes it checks the range.
  static CLI::Validator length() {
    return whole_number(0, std::numeric_limits<std::int32_t>::max()).description("");
  }

  Common common_;
  BoundaryOptions boundary_;
  std::string input_, output_;
  std::uint64_t memory_ = 0;
  std::string scratch_;
};

}  // namespace boxunion::command

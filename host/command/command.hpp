#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "boxunion/files.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "boxunion/volume.hpp"
#include "core/boundary/points.hpp"
#include "core/models/sections.hpp"
#include "host/bench/kernel_bench.hpp"
#include "host/external/external_union.hpp"

// The subcommands of the command line. Each prints its results to stdout, and progress and warnings to
// stderr. It throws Error, and is interruptible (see Interruptible).

namespace boxunion::command {

/// Options that several subcommands take.
struct Common {
  Options engine;        ///< method, device, threads, tuning, statistics
  VolumeOptions volume;  ///< threshold and model, if the input is voxels
  /// Limits of memory and scratch. If empty, all boxes are held in memory.
  std::optional<Budget> budget;
  bool json = false, quiet = false;
};

/// Prints the mass properties of the union of the boxes in `input`.
void measure(const std::string& input, const Common& common);

/// Options of `boundary`.
struct BoundaryOptions {
  bool triangles = false;                  ///< write triangles even if the format has other polygons
  std::optional<NonManifold> nonmanifold;  ///< default: split for .stl and .3mf, otherwise keep
};

/// Writes the boundary of the union of the boxes in `input` to `output`: vertices or a mesh.
void boundary(const std::string& input, const std::string& output, const BoundaryOptions& boundary_options,
              const Common& common);

/// A model that `decompose` makes: extreme vertices or one of disjoint boxes.
enum class Model { evm, oudb, cudb };

/// Options of `decompose`.
struct DecomposeOptions {
  Model model = Model::cudb;
  std::optional<AxisOrder> order = kAxisOrders[0];  ///< empty: the order with the fewest elements
  std::optional<Connectivity> connectivity;         ///< find neighbor lists of this connectivity, if given
};

/// Makes a model of the union of the boxes in `input` and writes it to `output`, if that is not empty.
void decompose(const std::string& input, const std::string& output, const DecomposeOptions& decompose_options,
               const Common& common);

/// Options of `label`.
struct LabelOptions {
  Connectivity connectivity = Connectivity::faces;
  std::string components;  ///< file for a table of the components, if not empty
};

/// Finds the connected components of the union of the boxes or voxels in `input`. If `output` is not empty,
/// writes a volume of labels for a volume, or disjoint boxes with their labels for boxes.
void label(const std::string& input, const std::string& output, const LabelOptions& label_options,
           const Common& common);

/// Prints the mass properties of a boolean expression over sets of boxes, given as NAME=FILE. Writes its
/// boundary to `output` and disjoint boxes to `boxes`, if these are not empty. Warns of sets that the
/// expression does not name.
void combine(const std::string& expression, const std::vector<std::string>& sets, const std::string& output,
             const std::string& boxes, const BoundaryOptions& boundary_options, const Common& common);

/// Writes generated boxes to `output`.
void generate(const BoxGenerator& generator, const std::string& output, const Common& common);

/// Writes a generated volume to `output`: its voxels (.npy) if `as_voxels`, otherwise its boxes.
void generate_volume(const std::function<Volume()>& generator, bool as_voxels, const std::string& output,
                     const Common& common);

/// Options of `bench`.
struct BenchOptions {
  KernelBenchOptions cases;
  bool quick = false;                ///< few small cases, unless options name some
  std::string json;                  ///< file for the results, if not empty
  std::optional<std::string> tune;   ///< choose the best launches and write them here; empty: tuning_path()
  std::vector<std::string> compare;  ///< two files of earlier results; nothing is run
};

/// Benchmarks the kernels and prints a table, or compares two earlier results.
void bench(const BenchOptions& bench_options, const Common& common);

/// Lists the devices of this machine, and the launches in use on them.
void devices(const Common& common);

/// Tries every kernel on every device and prints the results. Throws Error(device) at the end if one failed.
void check_devices(const Common& common);

}  // namespace boxunion::command

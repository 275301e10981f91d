#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/generate.hpp"
#include "core/points.hpp"
#include "core/voxel_labels.hpp"
#include "host/engine.hpp"
#include "host/volume.hpp"

// The subcommands of the command line. Each prints its results to stdout and its progress and warnings to
// stderr, throws Error, and stops with Error(interrupted) soon after `interrupted` becomes true.

namespace boxunion::command {

/// Options that several subcommands take.
struct Common {
  Options engine;        ///< method, device, threads, tuning, statistics
  VolumeOptions volume;  ///< threshold and model, where the input is voxels
  bool json = false, quiet = false;
  const std::atomic<bool>* interrupted = nullptr;
};

/// Prints the mass properties of the union of the boxes in `input`.
void measure(const std::string& input, const Common& common);

/// What `boundary` is asked for besides its files.
struct BoundaryOptions {
  bool triangles = false;                  ///< no other polygons, even where the format has them
  std::optional<NonManifold> nonmanifold;  ///< default: split for .stl and .3mf, else keep
};

/// Writes the boundary of the union of the boxes in `input` to `output`: vertices or a mesh.
void boundary(const std::string& input, const std::string& output, const BoundaryOptions& boundary_options,
              const Common& common);

/// Writes generated boxes to `output`.
void generate(const BoxGenerator& generator, const std::string& output, const Common& common);

/// Writes a generated volume to `output`: its voxels (.npy) if `as_voxels`, else its boxes.
void generate_volume(const std::function<Volume()>& generator, bool as_voxels, const std::string& output,
                     const Common& common);

/// Labels the connected components of the voxels of `input`. Writes the labels to `output` (.npy) unless it
/// is empty.
void label(const std::string& input, VoxelConnectivity connectivity, const std::string& output,
           const Common& common);

/// Lists the devices of this machine.
void devices(const Common& common);

}  // namespace boxunion::command

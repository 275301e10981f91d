#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "boxunion/brep.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/evm.hpp"
#include "boxunion/export.hpp"
#include "boxunion/files.hpp"
#include "boxunion/mass.hpp"
#include "boxunion/union.hpp"
#include "boxunion/volume.hpp"

// Unions of more boxes than memory holds, from file to file: the same results, to the last bit and byte, as
// from memory. By distribution sweeping (Goodrich, Tsay, Vengroff, Vitter, 1993): boxes are cut into slabs on
// disk that fit the budget, and each slab goes through the engine.
//
// All functions read the files that read_boxes reads. They throw as it and measure do, and Error(resources)
// where the budget is too small, which says how much it takes, or the disk is full. Options::threads and
// Options::interrupted hold for all of the work.

namespace boxunion {

/// How much memory a union may take, and where the rest goes.
struct Budget {
  /// Of the whole process on the native device: what boxunion allocates, its code and its threads. What the
  /// drivers of other devices allocate, as far as boxunion does not ask for it, is beyond it.
  std::uint64_t bytes = 0;
  std::string scratch;           ///< folder for nameless files
  std::uint64_t slab_boxes = 0;  ///< if not 0, the most boxes of a slab, even where more would fit
};

/// How a run within a budget went.
struct ExternalReport {
  Report engine;
  std::uint64_t boxes = 0, degenerate_boxes = 0;
  std::uint64_t slabs = 0;  ///< that went through the engine
};

/// Mass properties of the union of the boxes of a file.
BOXUNION_API MassProperties measure_file(const std::string& input, const Budget& budget,
                                         const Options& options = {}, const VolumeOptions& volume = {},
                                         ExternalReport* report = nullptr);

/// Every shell that is no cavity encloses a body.
struct ShellCounts {
  std::uint64_t shells = 0, cavities = 0;
};

/// Sizes of a boundary.
struct BoundaryCounts {
  std::uint64_t faces = 0, holes = 0, triangles = 0;
  /// Nothing where the budget does not hold what counting them takes: shells_bytes.
  std::optional<ShellCounts> shells;
  std::uint64_t shells_bytes = 0;
};

/// Writes the boundary of the union of the boxes of a file as a mesh, as write_mesh does.
BOXUNION_API BoundaryCounts write_boundary(const std::string& input, const std::string& output,
                                           const Budget& budget, NonManifold contacts = NonManifold::keep,
                                           bool triangles_only = false, const Options& options = {},
                                           const VolumeOptions& volume = {},
                                           ExternalReport* report = nullptr);

/// Writes the disjoint boxes of the union of the boxes of a file, as write_boxes does, or its extreme
/// vertices if there is no `model`. The order is the given one, or the one with the fewest boxes. Returns the
/// number of boxes or vertices.
BOXUNION_API std::uint64_t write_decomposition(const std::string& input, const std::string& output,
                                               const Budget& budget,
                                               std::optional<BoxModel> model = BoxModel::cudb,
                                               const std::optional<AxisOrder>& order = {},
                                               const Options& options = {}, const VolumeOptions& volume = {},
                                               ExternalReport* report = nullptr);

}  // namespace boxunion

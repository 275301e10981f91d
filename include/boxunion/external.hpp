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

// Unions of more boxes than memory holds, from file to file. The results are the same as from memory, to the
// last bit and byte. Distribution sweeping (Goodrich, Tsay, Vengroff, Vitter, 1993) cuts the boxes into slabs
// on disk that fit the budget, and each slab goes through the engine.
//
// All functions read the files that read_boxes reads. They throw as read_boxes and measure do. They throw
// Error(resources) if the disk is full, or if the budget is too small, with a message that says how much is
// needed. Options::threads and Options::interrupted apply to all of the work.

namespace boxunion {

/// How much memory a union may take, and where everything else goes.
struct Budget {
  /// The budget of the whole process on the native device: the memory that boxunion allocates, its code and
  /// its threads. It does not cover memory that the drivers of other devices allocate for themselves.
  std::uint64_t bytes = 0;
  std::string scratch;           ///< folder for nameless files
  std::uint64_t slab_boxes = 0;  ///< if not 0, the maximum number of boxes in a slab, even if more would fit
};

/// The report of a run within a budget.
struct ExternalReport {
  Report engine;
  std::uint64_t boxes = 0, degenerate_boxes = 0;
  std::uint64_t slabs = 0;  ///< number of slabs that went through the engine
};

/// The mass properties of the union of the boxes of a file.
BOXUNION_API MassProperties measure_file(const std::string& input, const Budget& budget,
                                         const Options& options = {}, const VolumeOptions& volume = {},
                                         ExternalReport* report = nullptr);

/// Counts of shells. Every shell that is not a cavity encloses a body.
struct ShellCounts {
  std::uint64_t shells = 0, cavities = 0;
};

/// Counts of a boundary.
struct BoundaryCounts {
  std::uint64_t faces = 0, holes = 0, triangles = 0;
  /// Nothing if counting them would need more than the budget: shells_bytes.
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
/// vertices if there is no `model`. If no order is given, takes the one with the fewest boxes. Returns the
/// number of boxes or vertices.
BOXUNION_API std::uint64_t write_decomposition(const std::string& input, const std::string& output,
                                               const Budget& budget,
                                               std::optional<BoxModel> model = BoxModel::cudb,
                                               const std::optional<AxisOrder>& order = {},
                                               const Options& options = {}, const VolumeOptions& volume = {},
                                               ExternalReport* report = nullptr);

}  // namespace boxunion

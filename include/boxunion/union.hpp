#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/brep.hpp"
#include "boxunion/device.hpp"
#include "boxunion/export.hpp"
#include "boxunion/expression.hpp"
#include "boxunion/mass.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/solid.hpp"
#include "boxunion/statistics.hpp"

namespace boxunion {

/// How the union is computed; the result is the same to the last bit.
enum class Method {
  automatic,  ///< cells, or natively, without statistics, a sweep of its own for boxes that share a corner
  cells,
  slices
};

/// What computes a cell; the result is the same to the last bit.
enum class CellKernel {
  occupancy,  ///< a bitmap of the cell, 32 points at a time
  faces       ///< UNION3's own test of all triples of faces: cubic in the cell's boxes, a baseline
};

/// What a run is asked to do, beside its boxes.
struct Options {
  Method method = Method::automatic;
  CellKernel kernel = CellKernel::occupancy;
  std::string device = "auto";  ///< see open_device
  int threads = 0;              ///< threads of the host, 0 for one per core
  Tuning tuning{};
  bool statistics = false;  ///< measure: fill Report::statistics, which costs some speed
  /// Whether a device that fails only costs a warning, and its work goes on natively; else the run ends with
  /// Error(device), as it does where a device cannot do all of the work.
  bool fallback = true;

  /// Called now and then, from any thread, with the fraction of the work that is done (0 to 1).
  std::function<void(double)> progress{};
  /// Called with one line for the user, for example when a batch fails on the device and runs natively.
  std::function<void(const std::string&)> warn{};
  /// Where this becomes true the run ends soon with Error(interrupted).
  const std::atomic<bool>* interrupted = nullptr;
};

/// How a run went.
struct Report {
  std::string method;  ///< "cells", "slices", "staircase"
  std::string kernel;  ///< "occupancy", "faces", "contour", "none"
  std::string device;  ///< DeviceInfo::id of the device that was used
  /// Seconds by stage in order of work; the last is "total", from boxes in memory to the result.
  std::vector<std::pair<std::string, double>> seconds;
  CellStatistics cells;                  ///< method cells: what the grid did
  std::optional<Statistics> statistics;  ///< if asked for
};

/// Mass properties of the union of `boxes`, without ever holding its vertices.
/// Throws Error(input) for invalid boxes, Error(device) where the device cannot be opened.
BOXUNION_API MassProperties measure(const BoxSet& boxes, const Options& options = {},
                                    Report* report = nullptr);

/// The vertices of the union of `boxes`. Throws as measure does.
BOXUNION_API Solid unite(const BoxSet& boxes, const Options& options = {}, Report* report = nullptr);

/// Mass properties of a boolean expression over sets of boxes, regularised as a union is, without ever
/// holding its vertices. `sets` are the operands in the order of expression.names(); each stands for the
/// union of its boxes. Throws as measure does, and Error(usage) where the number of sets is wrong, for
/// statistics of more than one set, and where Method::slices or CellKernel::faces is asked for more than a
/// union.
BOXUNION_API MassProperties measure(const Expression& expression, std::span<const BoxSet> sets,
                                    const Options& options = {}, Report* report = nullptr);

/// The vertices of a boolean expression over sets of boxes. Throws as measure does. Coordinates that no
/// vertex has may be among the axes' ones.
BOXUNION_API Solid combine(const Expression& expression, std::span<const BoxSet> sets,
                           const Options& options = {}, Report* report = nullptr);

/// A boundary and its triangles, face by face.
struct Boundary {
  Brep brep;
  Triangulation triangulation;
};

/// The boundary of a union that unite has found; goes on with its report. Throws Error(resources) where an
/// index would not fit 32 bits or memory does not suffice, Error(interrupted) soon after options.interrupted
/// becomes true.
BOXUNION_API Boundary find_boundary(const Solid& solid, NonManifold contacts, const Options& options = {},
                                    Report* report = nullptr);

}  // namespace boxunion

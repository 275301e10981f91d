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

/// How the union is computed. The result is the same to the last bit.
enum class Method {
  automatic,  ///< cells; natively and without statistics, a sweep if the boxes share a corner
  cells,
  slices
};

/// How a cell is computed. The result is the same to the last bit.
enum class CellKernel {
  occupancy,  ///< a bitmap of the cell, up to 64 points at a time
  faces       ///< UNION3's own test of all triples of faces, cubic in the boxes of a cell; for comparison
};

/// The options of a run.
struct Options {
  Method method = Method::automatic;
  CellKernel kernel = CellKernel::occupancy;
  std::string device = "auto";  ///< "auto", a kind such as "opencl", or an id of list_devices()
  int threads = 0;              ///< threads of the host; 0: one per core
  Tuning tuning{};
  bool statistics = false;  ///< make measure() fill Report::statistics, at some cost of speed
  /// If true, a device that fails causes a warning, and its work continues natively. If false, the run ends
  /// with Error(device), even if a device only cannot do all of the work.
  bool fallback = true;

  /// Called now and then, from any thread, with the fraction of the work done (0 to 1).
  std::function<void(double)> progress{};
  /// Called with a line for the user, for example when a batch fails on the device and runs natively.
  std::function<void(const std::string&)> warn{};
  /// When this becomes true, the run ends soon with Error(interrupted).
  const std::atomic<bool>* interrupted = nullptr;
};

/// The report of a run.
struct Report {
  std::string method;  ///< "cells", "slices", "staircase"
  std::string kernel;  ///< "occupancy", "faces", "contour", "none"
  std::string device;  ///< DeviceInfo::id of the device that was used
  /// Seconds by stage in order of work; the last is "total", from boxes in memory to the result.
  std::vector<std::pair<std::string, double>> seconds;
  CellStatistics cells;                  ///< with method cells
  std::optional<Statistics> statistics;  ///< if requested
};

/// The mass properties of the union of `boxes`, without holding its vertices. Throws Error(input) for invalid
/// boxes, Error(device) if the device cannot be opened.
BOXUNION_API MassProperties measure(const BoxSet& boxes, const Options& options = {},
                                    Report* report = nullptr);

/// The vertices of the union of `boxes`. Throws as measure does.
BOXUNION_API Solid unite(const BoxSet& boxes, const Options& options = {}, Report* report = nullptr);

/// The mass properties of a boolean expression over sets of boxes, regularised like a union, without holding
/// its vertices. `sets` are the operands in the order of expression.names(). Each stands for the union of its
/// boxes. Throws as measure does. Throws Error(usage) if the number of sets is wrong, for statistics of more
/// than one set, and for Method::slices or CellKernel::faces with anything but a union.
BOXUNION_API MassProperties measure(const Expression& expression, std::span<const BoxSet> sets,
                                    const Options& options = {}, Report* report = nullptr);

/// The vertices of a boolean expression over sets of boxes. The axes may have coordinates that no vertex has.
/// Throws as measure does.
BOXUNION_API Solid combine(const Expression& expression, std::span<const BoxSet> sets,
                           const Options& options = {}, Report* report = nullptr);

/// A boundary and its triangles, face by face.
struct Boundary {
  Brep brep;
  Triangulation triangulation;
};

/// The boundary of a union that `unite` has found. Continues its report. Throws Error(resources) if an index
/// does not fit 32 bits or memory does not suffice, and Error(interrupted) soon after options.interrupted
/// becomes true.
BOXUNION_API Boundary find_boundary(const Solid& solid, NonManifold contacts, const Options& options = {},
                                    Report* report = nullptr);

}  // namespace boxunion

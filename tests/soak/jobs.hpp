#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/connectivity.hpp"
#include "core/boundary/triangulation.hpp"
#include "core/models/decomposition.hpp"
#include "host/engine/engine.hpp"

namespace boxunion::soak {

/// What is made of a union in slabs on disk, compared with the same from memory.
struct Slabs {
  std::uint64_t boxes;  // at most, of a slab
  std::uint64_t bytes;  // of the budget
  std::string file;     // what for: "" for mass properties
  std::optional<BoxModel> model;
  std::optional<AxisOrder> order;
  std::optional<Connectivity> connectivity;  // of neighbors to be counted, of boxes
  NonManifold contacts;
};

/// Boxes and a way to find their union.
struct Job {
  std::string boxes_name;
  BoxSet boxes;
  std::size_t count = 0;
  Options options;
  std::string failure;                // of the device
  bool at_once = false;               ///< measured and united by two threads at once
  std::optional<double> disturbance;  ///< once more with an exception, then an interrupt, after this fraction
  std::optional<Slabs> slabs;
};

Job make_job(std::uint64_t seed, const std::vector<std::string>& devices);
std::string name(const Job& job);

/// What is wrong, or nothing. Counts in `done`.
std::string run(const Job& job, std::map<std::string, int>& done);

}  // namespace boxunion::soak

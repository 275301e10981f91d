#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "boxunion/decomposition.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "boxunion/volume.hpp"

namespace boxunion::soak {

/// A union in slabs on disk, which is compared with the same union from memory.
struct Slabs {
  std::uint64_t boxes;  // maximum boxes of a slab
  std::uint64_t bytes;  // the budget
  std::string file;     // the output; "" for mass properties
  std::optional<BoxModel> model;
  std::optional<AxisOrder> order;
  std::optional<Connectivity> connectivity;  // count neighbors of this connectivity, if given
  NonManifold contacts;
};

/// Boxes and a way to find their union.
struct Job {
  std::string boxes_name;
  BoxSet boxes;
  std::size_t count = 0;
  Options options;
  std::string failure;                // a call of the device that fails
  bool at_once = false;               ///< measured and united by two threads at once
  std::optional<double> disturbance;  ///< once more with an exception, then an interrupt, after this fraction
  std::optional<Slabs> slabs;
};

Job make_job(std::uint64_t seed, const std::vector<std::string>& devices);
std::string name(const Job& job);

/// Returns a description of the fault, or nothing. Counts the kinds of jobs in `done`.
std::string run(const Job& job, std::map<std::string, int>& done);

}  // namespace boxunion::soak

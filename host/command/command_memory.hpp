#pragma once

#include <cstdint>
#include <string>

#include "boxunion/box.hpp"
#include "boxunion/union.hpp"
#include "host/command/command.hpp"

// How the commands keep to --memory.
namespace boxunion::command {

/// If `options` select the native device, limits the process to `bytes` of memory in total: an allocation
/// beyond them throws std::bad_alloc. (Drivers of other devices take as much as they want.) Starts the
/// threads first, because their stacks have more addresses than memory. Does nothing under sanitizers.
void limit_memory(std::uint64_t bytes, const Options& options);

/// Reads boxes that are all held in memory, as far as a budget allows.
class HeldBoxes {
 public:
  /// Throws Error(resources) for a budget that is too small for any run.
  explicit HeldBoxes(const Common& common);

  /// Throws as read_boxes does, and Error(resources) if these boxes and those read before do not fit the
  /// budget.
  BoxSet read(const std::string& path);

 private:
  const Common& common_;
  std::uint64_t bytes_ = 0;
};

}  // namespace boxunion::command

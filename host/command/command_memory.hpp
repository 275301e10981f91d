#pragma once

#include <cstdint>
#include <string>

#include "core/boxes/box.hpp"
#include "host/command/command.hpp"
#include "host/engine/engine.hpp"

// How the commands keep to --memory.
namespace boxunion::command {

/// Where `options` mean the native device, lets the process take so many bytes of memory, all together: an
/// allocation beyond them throws std::bad_alloc. (Drivers of other devices take what they like.) Starts the
/// threads first, whose stacks hold more addresses than memory. Does nothing under sanitizers.
void limit_memory(std::uint64_t bytes, const Options& options);

/// Reads boxes that are all held in memory, as far as a budget allows that.
class HeldBoxes {
 public:
  /// Throws Error(resources) for a budget that is too small for any run.
  explicit HeldBoxes(const Common& common);

  /// Throws as read_boxes does, and Error(resources) where these boxes and those read before do not fit the
  /// budget.
  BoxSet read(const std::string& path);

 private:
  const Common& common_;
  std::uint64_t bytes_ = 0;
};

}  // namespace boxunion::command

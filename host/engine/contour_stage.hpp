#pragma once

#include <memory>
#include <span>
#include <vector>

#include "boxunion/union.hpp"
#include "core/slices/slices.hpp"
#include "core/slices/xor_merge.hpp"
#include "host/device/device.hpp"

namespace boxunion {

/// Runs the kernel `contour` on a device. It gets tiles and finds their contour vertices.
class ContourStage {
 public:
  ContourStage(Device& device, const Tuning& tuning);

  /// Replaces `vertices` by the contour vertices of all tiles. Tile i has [offsets[i], offsets[i + 1]), in no
  /// particular order. Makes as many dispatches as the limits of the device require.
  void run(const Tiles& tiles, std::vector<ContourVertex>& vertices, std::vector<std::size_t>& offsets);

 private:
  void run_range(const Tiles& tiles, std::size_t first, std::size_t last,
                 std::vector<ContourVertex>& vertices, std::vector<std::size_t>& offsets);

  Device& device_;
  std::unique_ptr<Kernel> kernel_;
  std::unique_ptr<Buffer> tile_, rectangle_, found_, vertex_, total_;
};

}  // namespace boxunion

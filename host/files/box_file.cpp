#include "host/files/box_file.hpp"

#include "core/base/parallel.hpp"
#include "host/files/formats.hpp"

namespace boxunion {

std::unique_ptr<BoxFile> open_boxes(const std::string& path, const Budget& budget,
                                    const std::atomic<bool>* interrupted, const VolumeOptions& volume) {
  const Interruptible scope(interrupted ? interrupted : Interruptible::flag());
  return open_input(path, FileUse::input, interrupted, volume)->open(budget);
}

}  // namespace boxunion

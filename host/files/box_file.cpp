#include "host/files/box_file.hpp"

#include "host/files/formats.hpp"

namespace boxunion {

std::unique_ptr<BoxFile> open_boxes(const std::string& path, const Budget& budget,
                                    const VolumeOptions& volume) {
  return open_input(path, FileUse::input, volume)->open(budget);
}

}  // namespace boxunion

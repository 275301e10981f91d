#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "boxunion/box.hpp"
#include "boxunion/external.hpp"
#include "boxunion/files.hpp"

namespace boxunion {

/// Boxes in a file that are read in pieces, in any order and any number of times, so that they need not be in
/// memory.
class BoxFile {
 public:
  virtual ~BoxFile() = default;
  virtual std::uint64_t size() const = 0;
  /// Boxes begin .. end - 1, valid or not. Thread-safe. Throws Error(input) if they cannot be read.
  virtual BoxSet read(std::uint64_t begin, std::uint64_t end) const = 0;
  /// The name of box `row`, counted from 0, in messages: "boxes.npy: row 1".
  virtual std::string name_of(std::uint64_t row) const = 0;
};

/// Opens boxes for reading in pieces. .npy is read as it is. .csv, standard input ("-") and volumes must be
/// read from their start, so they are copied to a nameless file on disk, at 48 bytes a box, or 24 if the
/// boxes of a volume are integers. Throws as read_boxes (files.hpp) does, and Error(resources) if slices of a
/// volume, or the models of a scene (.vox), may not fit the budget.
std::unique_ptr<BoxFile> open_boxes(const std::string& path, const Budget& budget,
                                    const VolumeOptions& volume = {});

}  // namespace boxunion

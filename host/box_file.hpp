#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "core/box.hpp"

namespace boxunion {

/// Boxes in a file, read piece by piece, in any order and as often as wanted, so that they need not be in
/// memory.
class BoxFile {
 public:
  virtual ~BoxFile() = default;
  virtual std::uint64_t size() const = 0;
  /// Boxes begin .. end - 1, valid or not. Thread-safe. Throws Error(input) where they cannot be read.
  virtual BoxSet read(std::uint64_t begin, std::uint64_t end) const = 0;
  /// What messages call box `row`, counted from 0: "boxes.npy: row 1".
  virtual std::string name_of(std::uint64_t row) const = 0;
};

/// Opens boxes for reading in pieces: .npy as it is; .csv and standard input ("-"), which must be read from
/// their start, are copied to a nameless file in the folder `scratch`, at 48 bytes a box. Throws as
/// read_boxes (files.hpp) does, and Error(usage) for volumes.
std::unique_ptr<BoxFile> open_boxes(const std::string& path, const std::string& scratch,
                                    const std::atomic<bool>* interrupted = nullptr);

}  // namespace boxunion

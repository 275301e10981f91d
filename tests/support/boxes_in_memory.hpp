#pragma once

#include <string>
#include <vector>

#include "boxunion/box.hpp"
#include "host/files/box_file.hpp"

namespace boxunion {

/// Boxes in memory that are read like a file.
class BoxesInMemory final : public BoxFile {
 public:
  explicit BoxesInMemory(const BoxSet& boxes) : boxes_(boxes) {}
  std::uint64_t size() const override { return boxes_.size(); }
  BoxSet read(std::uint64_t begin, std::uint64_t end) const override {
    return boxes_.visit([&]<class T>(const std::vector<BoxOf<T>>& all) {
      return BoxSet(
          std::vector<BoxOf<T>>(all.begin() + std::ptrdiff_t(begin), all.begin() + std::ptrdiff_t(end)));
    });
  }
  std::string name_of(std::uint64_t row) const override { return "row " + std::to_string(row + 1); }

 private:
  const BoxSet& boxes_;
};

}  // namespace boxunion

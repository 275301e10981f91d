#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "boxunion/box.hpp"
#include "boxunion/external.hpp"
#include "host/files/box_file.hpp"
#include "host/files/input.hpp"
#include "host/files/scratch.hpp"

namespace boxunion {

/// A copy, in binary numbers of one type, of a file that can only be read from its start.
class SpooledBoxes final : public BoxFile {
 public:
  SpooledBoxes(const InputFile& file, const Budget& budget);

  void append(std::span<const Box> boxes);
  void append(std::span<const IntegerBox> boxes);

  std::uint64_t size() const override;
  BoxSet read(std::uint64_t begin, std::uint64_t end) const override;
  std::string name_of(std::uint64_t row) const override;

 private:
  std::string name_;
  ScratchFile boxes_;
  bool are_integers_ = false;
};

/// Throws Error(resources) if reading a file takes more memory than the budget.
void require_memory(const InputFile& file, std::string_view what, std::uint64_t bytes, const Budget& budget);

}  // namespace boxunion

#include "host/files/spooled_boxes.hpp"

#include <fmt/format.h>

#include <vector>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

template <class T>
BoxSet read_as(const ScratchFile& file, std::uint64_t begin, std::uint64_t end) {
  std::vector<BoxOf<T>> boxes(end - begin);
  file.read_at(begin * sizeof(BoxOf<T>),
               {reinterpret_cast<char*>(boxes.data()), boxes.size() * sizeof(BoxOf<T>)});
  return boxes;
}

}  // namespace

SpooledBoxes::SpooledBoxes(const InputFile& file, const Budget& budget)
    : name_(file.name()), boxes_(budget.scratch) {}

void SpooledBoxes::append(std::span<const Box> boxes) {
  are_integers_ = false;
  boxes_.append({reinterpret_cast<const char*>(boxes.data()), boxes.size_bytes()});
}

void SpooledBoxes::append(std::span<const IntegerBox> boxes) {
  are_integers_ = true;
  boxes_.append({reinterpret_cast<const char*>(boxes.data()), boxes.size_bytes()});
}

std::uint64_t SpooledBoxes::size() const {
  return boxes_.size() / (are_integers_ ? sizeof(IntegerBox) : sizeof(Box));
}

BoxSet SpooledBoxes::read(std::uint64_t begin, std::uint64_t end) const {
  return are_integers_ ? read_as<std::int32_t>(boxes_, begin, end) : read_as<double>(boxes_, begin, end);
}

std::string SpooledBoxes::name_of(std::uint64_t row) const {
  return fmt::format("{}: box {}", name_, row + 1);
}

void require_memory(const InputFile& file, std::string_view what, std::uint64_t bytes, const Budget& budget) {
  constexpr std::uint64_t kBaseBytes = std::uint64_t{32} << 20;  // the process and buffers of readers
  if (kBaseBytes + bytes > budget.bytes)
    throw Error(ErrorKind::resources, fmt::format("{}: {} may take {} MiB, more than --memory allows",
                                                  file.name(), what, ((kBaseBytes + bytes) >> 20) + 1));
}

}  // namespace boxunion

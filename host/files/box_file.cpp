#include "host/files/box_file.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/files/files.hpp"
#include "host/files/formats.hpp"
#include "host/files/scratch.hpp"

namespace boxunion {
namespace {

/// A copy, in binary numbers of one type, of a file that can only be read from its start.
class SpooledFile final : public BoxFile {
 public:
  SpooledFile(std::string name, const std::string& scratch, const std::atomic<bool>* interrupted)
      : name_(std::move(name)), boxes_(scratch, interrupted) {}

  template <class T>
  void append(std::span<const BoxOf<T>> boxes) {
    is_integer_ = std::is_same_v<T, std::int32_t>;
    boxes_.append({reinterpret_cast<const char*>(boxes.data()), boxes.size_bytes()});
  }
  std::uint64_t size() const override {
    return boxes_.size() / (is_integer_ ? sizeof(IntegerBox) : sizeof(Box));
  }
  BoxSet read(std::uint64_t begin, std::uint64_t end) const override {
    return is_integer_ ? read_as<std::int32_t>(begin, end) : read_as<double>(begin, end);
  }
  std::string name_of(std::uint64_t row) const override { return fmt::format("{}: box {}", name_, row + 1); }

 private:
  template <class T>
  BoxSet read_as(std::uint64_t begin, std::uint64_t end) const {
    std::vector<BoxOf<T>> boxes(end - begin);
    boxes_.read_at(begin * sizeof(BoxOf<T>),
                   {reinterpret_cast<char*>(boxes.data()), boxes.size() * sizeof(BoxOf<T>)});
    return boxes;
  }

  std::string name_;
  ScratchFile boxes_;
  bool is_integer_ = false;
};

}  // namespace

std::unique_ptr<BoxFile> open_boxes(const std::string& path, const Budget& budget,
                                    const std::atomic<bool>* interrupted, const VolumeOptions& volume) {
  const Interruptible scope(interrupted ? interrupted : Interruptible::flag());
  InputBoxes input = open_input(path, interrupted, volume);
  const bool is_scene = input.format == FileFormat::vox;
  if (!input.voxels && !is_scene && input.format != FileFormat::csv)
    return npy::open_boxes(input.file, npy::read_header(*input.file));
  auto spooled = std::make_unique<SpooledFile>(input.file->name(), budget.scratch, interrupted);
  const auto require = [&](std::string_view what, std::uint64_t bytes) {
    constexpr std::uint64_t kBaseBytes = std::uint64_t{32} << 20;  // the process and buffers of readers
    if (kBaseBytes + bytes > budget.bytes)
      throw Error(ErrorKind::resources, fmt::format("{}: {} may take {} MiB, more than --memory allows", path,
                                                    what, ((kBaseBytes + bytes) >> 20) + 1));
  };
  if (is_scene) {
    vox::stream_boxes(
        *input.file, volume, [&](std::span<const IntegerBox> boxes) { spooled->append(boxes); },
        [&](std::uint64_t bytes) { require("the models of the scene", bytes); });
  } else if (input.voxels) {
    require("slices of the volume", stream_bytes(input.voxels->grid));
    stream_voxel_boxes(*input.voxels, [&](const BoxSet& set) {
      set.visit([&](const auto& boxes) { spooled->append(std::span(boxes)); });
    });
  } else {
    csv::stream_boxes(*input.file, [&](std::span<const Box> boxes) { spooled->append(boxes); });
  }
  return spooled;
}

}  // namespace boxunion

#include <memory>
#include <utility>

#include "boxunion/files.hpp"
#include "core/base/parallel.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/files/formats.hpp"
#include "host/files/spooled_boxes.hpp"

namespace boxunion {
namespace {

class VolumeInput final : public InputBoxes {
 public:
  VolumeInput(std::shared_ptr<const InputFile> file, VoxelStream voxels)
      : file_(std::move(file)), voxels_(std::move(voxels)) {}

  bool is_volume() const override { return true; }
  BoxSet read() override { return voxel_boxes(voxels_); }
  std::unique_ptr<BoxFile> open(const Budget& budget) override {
    require_memory(*file_, "slices of the volume", stream_bytes(voxels_.grid), budget);
    auto spooled = std::make_unique<SpooledBoxes>(*file_, budget);
    stream_voxel_boxes(voxels_, [&](const BoxSet& set) {
      set.visit([&](const auto& boxes) { spooled->append(std::span(boxes)); });
    });
    return spooled;
  }
  Volume read_volume() override { return collect(voxels_); }

 private:
  std::shared_ptr<const InputFile> file_;
  VoxelStream voxels_;
};

}  // namespace

std::unique_ptr<InputBoxes> volume_input(std::shared_ptr<const InputFile> file, VoxelStream voxels) {
  return std::make_unique<VolumeInput>(std::move(file), std::move(voxels));
}

bool is_volume(const std::string& path) {
  if (path == "-") return false;
  const Format& format = format_of(path, FileUse::input);
  if ((format.roles & (boxes_in | voxels_in)) != (boxes_in | voxels_in)) return format.roles & voxels_in;
  return format.reader(std::make_shared<InputFile>(path), {})->is_volume();
}

Volume read_volume(const std::string& path, const VolumeOptions& options,
                   const std::atomic<bool>* interrupted) {
  const Interruptible scope(interrupted ? interrupted : Interruptible::flag());
  return open_input(path, FileUse::volume, options)->read_volume();
}

}  // namespace boxunion

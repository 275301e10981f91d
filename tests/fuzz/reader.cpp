// Any bytes as a file of the format BOXUNION_FUZZ_EXTENSION: valid boxes, or an Error.

#include <fcntl.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "boxunion/error.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/files/files.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace boxunion::fuzz {
namespace {

/// A file in the memory of this process, which holds one input after the other.
class InputPath {
 public:
  InputPath() {
    const std::filesystem::path memory = "/dev/shm";
    path_ = std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path();
    path_ += "/boxunion-fuzz-" + std::to_string(::getpid()) + BOXUNION_FUZZ_EXTENSION;
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    expect(file_ >= 0);
  }
  ~InputPath() {
    ::close(file_);
    ::unlink(path_.c_str());
  }
  InputPath(const InputPath&) = delete;
  InputPath& operator=(const InputPath&) = delete;

  const std::string& with(const std::uint8_t* bytes, std::size_t count) {
    expect(::ftruncate(file_, 0) == 0 && ::pwrite(file_, bytes, count, 0) == ssize_t(count));
    return path_;
  }

 private:
  std::string path_;
  int file_ = -1;
};

/// The result of read(), or nothing if it throws an error that a reader may throw.
template <class F>
auto accepted(F&& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const Error& error) {
    expect(error.kind() == ErrorKind::input || error.kind() == ErrorKind::usage ||
           error.kind() == ErrorKind::resources);
    return std::nullopt;
  }
}

/// Checks that a volume has as many voxels inside as its boxes hold.
void expect_boxes_of(const Volume& volume) {
  std::uint64_t inside = 0, boxed = 0;
  for (const std::uint8_t voxel : volume.inside) inside += voxel != 0;
  for (const IntegerBox& b : index_boxes(stream_of(volume)))
    boxed += std::uint64_t(b[3] - b[0]) * std::uint64_t(b[4] - b[1]) * std::uint64_t(b[5] - b[2]);
  expect(inside == boxed);
}

/// True if the bounds of integer boxes are small. A scene may place voxels far apart, and its volume has the
/// size of the bounds.
bool is_compact(const BoxSet& boxes) {
  std::array<double, 6> bounds{};
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      const Box box = boxes[i];
      bounds[a] = i == 0 ? box[a] : std::min(bounds[a], box[a]);
      bounds[a + 3] = i == 0 ? box[a + 3] : std::max(bounds[a + 3], box[a + 3]);
    }
  return (bounds[3] - bounds[0]) * (bounds[4] - bounds[1]) * (bounds[5] - bounds[2]) < 0x1p25;
}

void read(const std::string& path) {
  const auto read_with = [&](const VolumeOptions& options) {
    auto boxes = accepted([&] { return read_boxes(path, nullptr, options); });
    if (boxes) expect(find_invalid(*boxes) == boxes->size());
    return boxes;
  };
  read_with({.threshold = 2.5});
  read_with({.model = 1});
  const auto boxes = read_with({});
  const auto is_voxels = accepted([&] { return is_volume(path); });
  if (!boxes || !is_voxels || !*is_voxels) return;
  if (path.ends_with(".vox") && !is_compact(*boxes)) return;
  if (const auto volume = accepted([&] { return read_volume(path); })) expect_boxes_of(*volume);
}

}  // namespace
}  // namespace boxunion::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  static boxunion::fuzz::InputPath file;
  boxunion::fuzz::read(file.with(bytes, count));
  return 0;
}

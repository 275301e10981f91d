#include "host/box_file.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/error.hpp"
#include "host/files.hpp"
#include "host/formats.hpp"
#include "host/scratch.hpp"

namespace boxunion {
namespace {

/// What a text file says, as binary numbers.
class ParsedFile final : public BoxFile {
 public:
  ParsedFile(InputFile& file, const std::string& scratch, const std::atomic<bool>* interrupted)
      : name_(file.name()), parsed_(scratch, interrupted) {
    csv::stream_boxes(file, [&](std::span<const Box> boxes) {
      parsed_.append({reinterpret_cast<const char*>(boxes.data()), boxes.size_bytes()});
    });
  }
  std::uint64_t size() const override { return parsed_.size() / sizeof(Box); }
  BoxSet read(std::uint64_t begin, std::uint64_t end) const override {
    std::vector<Box> boxes(end - begin);
    parsed_.read_at(begin * sizeof(Box), {reinterpret_cast<char*>(boxes.data()), boxes.size() * sizeof(Box)});
    return boxes;
  }
  std::string name_of(std::uint64_t row) const override { return fmt::format("{}: box {}", name_, row + 1); }

 private:
  std::string name_;
  ScratchFile parsed_;
};

}  // namespace

std::unique_ptr<BoxFile> open_boxes(const std::string& path, const std::string& scratch,
                                    const std::atomic<bool>* interrupted) {
  const FileFormat format = path == "-" ? FileFormat::csv : file_format(path, kInputFormats);
  if (is_volume(path))
    throw Error(ErrorKind::usage, fmt::format("{}: a memory budget is for boxes, not for voxels", path));
  const auto file = std::make_shared<InputFile>(path, interrupted);
  if (format == FileFormat::csv) return std::make_unique<ParsedFile>(*file, scratch, interrupted);
  return npy::open_boxes(file, npy::read_header(*file));
}

}  // namespace boxunion

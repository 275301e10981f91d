#include "host/files/volume_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "host/files/voxel_data.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kLongestHeader = std::size_t{1} << 20;

std::vector<std::string_view> words(std::string_view text) {
  constexpr std::string_view kBlanks = " \t,()";
  std::vector<std::string_view> all;
  for (std::size_t begin; (begin = text.find_first_not_of(kBlanks)) != text.npos;) {
    text.remove_prefix(begin);
    const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
    all.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return all;
}

template <class T>
std::optional<T> parse(std::string_view word) {
  T value{};
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
  text.remove_prefix(begin);
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

VolumeHeader::VolumeHeader(std::shared_ptr<const InputFile> file) : file_(std::move(file)) {
  const std::uint64_t size = regular_size(*file_);
  text_.resize(std::size_t(std::min<std::uint64_t>(size, kLongestHeader)));
  is_cut_ = text_.size() < size;
  file_->read_at(0, text_);
}

std::optional<std::string_view> VolumeHeader::take_line() {
  if (position_ == text_.size() && !is_cut_) return std::nullopt;
  const std::size_t end = text_.find('\n', position_);
  if (end == text_.npos && is_cut_)
    reject(*file_, fmt::format("found no end of the header in {} bytes", text_.size()));
  const std::size_t length = std::min(end, text_.size()) - position_;
  std::string_view line(text_.data() + position_, length);
  position_ += std::min(length + 1, text_.size() - position_);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

void VolumeHeader::add(const std::string& field, std::string_view value) {
  if (!fields_.emplace(field, value).second)
    reject(*file_, fmt::format("the header has {} twice", shortened(field)));
}

const std::string* VolumeHeader::find(const std::string& field) const {
  const auto found = fields_.find(field);
  return found == fields_.end() ? nullptr : &found->second;
}

const std::string& VolumeHeader::get(const std::string& field) const {
  const std::string* value = find(field);
  if (!value) reject(*file_, fmt::format("the header has no {}", field));
  return *value;
}

std::vector<double> VolumeHeader::numbers(const std::string& field, std::size_t count) const {
  const std::string& value = get(field);
  std::vector<double> all;
  for (const std::string_view word : words(value)) {
    const auto number = parse<double>(word);
    if (!number || !std::isfinite(*number)) break;
    all.push_back(*number);
  }
  if (all.size() != count || words(value).size() != count)
    reject(*file_, fmt::format("{} is \"{}\", expected {} finite numbers", field, shortened(value), count));
  return all;
}

std::array<std::size_t, 3> VolumeHeader::extents(const std::string& field) const {
  const std::string& value = get(field);
  std::array<std::uint64_t, 3> extents{};
  const auto all = words(value);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto extent = all.size() == 3 ? parse<std::uint64_t>(all[a]) : std::nullopt;
    if (!extent)
      reject(*file_, fmt::format("{} is \"{}\", expected three whole numbers", field, shortened(value)));
    extents[a] = *extent;
  }
  check_extents(*file_, extents);
  return {extents[0], extents[1], extents[2]};
}

std::int64_t VolumeHeader::whole(const std::string& field, std::int64_t otherwise) const {
  const std::string* value = find(field);
  if (!value) return otherwise;
  const auto number = parse<std::int64_t>(*value);
  if (!number) reject(*file_, fmt::format("{} is \"{}\", expected a whole number", field, shortened(*value)));
  return *number;
}

void VolumeHeader::place(VoxelGrid& grid, const std::string& field,
                         const std::array<std::array<double, 3>, 3>& steps,
                         const std::array<double, 3>& centre) const {
  std::array<bool, 3> is_taken{};
  for (std::size_t a = 0; a < 3; ++a) {
    std::size_t nonzero = 0;
    for (std::size_t c = 0; c < 3; ++c)
      if (steps[a][c] != 0) {
        ++nonzero;
        grid.axes[a] = c;
      }
    if (nonzero != 1 || std::exchange(is_taken[grid.axes[a]], true))
      reject(*file_,
             fmt::format(
                 "{} turns axis {} to ({}, {}, {}), expected axes along x, y and z: boxes cannot be oblique",
                 field, a + 1, steps[a][0], steps[a][1], steps[a][2]));
    grid.spacing[a] = steps[a][grid.axes[a]];
    grid.origin[a] = centre[grid.axes[a]] - grid.spacing[a] / 2;
  }
}

std::shared_ptr<const InputFile> VolumeHeader::open_beside(const std::string& name) const {
  const std::filesystem::path folder = std::filesystem::path(file_->name()).parent_path();
  return std::make_shared<InputFile>((folder / name).string());
}

}  // namespace boxunion

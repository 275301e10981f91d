#include "host/files/npy_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <span>

#include "host/files/voxel_data.hpp"

namespace boxunion::npy {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::uint64_t kLongestHeader = std::uint64_t{1} << 20;

/// Removes a Python value from the start of `text`: everything up to a comma or bracket outside all quotes
/// and brackets.
std::string take_value(std::string_view& text) {
  int depth = 0;
  char quote = 0;
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    const char c = text[end];
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '(' || c == '[' || c == '{') {
      ++depth;
    } else if (depth == 0 && (c == ',' || c == ':' || c == '}')) {
      break;
    } else if (c == ')' || c == ']' || c == '}') {
      --depth;
    }
  }
  std::string value(text.substr(0, end));
  text.remove_prefix(std::min(end + 1, text.size()));
  const std::size_t first = value.find_first_not_of(" \n");
  if (first == value.npos) return "";
  return value.substr(first, value.find_last_not_of(" \n") + 1 - first);
}

/// A value without its quotes, if it has any.
std::string unquoted(const std::string& value) {
  const bool is_quoted = value.size() >= 2 && (value.front() == '\'' || value.front() == '"');
  return is_quoted ? value.substr(1, value.size() - 2) : value;
}

}  // namespace

std::optional<std::vector<std::uint64_t>> Header::extents() const {
  std::vector<std::uint64_t> extents;
  if (!shape.starts_with('(')) return std::nullopt;
  for (std::size_t i = 1; i < shape.size(); ++i) {
    const char c = shape[i];
    if ('0' <= c && c <= '9') {
      if (shape[i - 1] < '0' || shape[i - 1] > '9') extents.push_back(0);
      std::uint64_t& extent = extents.back();
      if (extent > (std::numeric_limits<std::uint64_t>::max() - 9) / 10) return std::nullopt;
      extent = 10 * extent + std::uint64_t(c - '0');
    } else if (c != ',' && c != ' ' && c != ')') {
      return std::nullopt;
    }
  }
  return extents;
}

Header read_header(const InputFile& file) {
  const auto size = file.size();
  if (!size) reject(file, "cannot read NPY from a pipe, expected a regular file");
  const std::uint64_t file_size = *size;
  std::array<unsigned char, 12> start{};
  const auto got = std::size_t(std::min<std::uint64_t>(start.size(), file_size));
  file.read_at(0, std::span(reinterpret_cast<char*>(start.data()), got));
  if (file_size == 0) reject(file, "no boxes: the file is empty; expected an NPY array of shape (n, 6)");
  if (got < 10 || std::memcmp(start.data(), kMagic.data(), kMagic.size()) != 0)
    reject(file, "not an NPY file, expected it to start with \\x93NUMPY");
  const int version = start[6];
  if (version < 1 || version > 3)
    reject(file, fmt::format("found NPY version {}.{}, expected 1, 2 or 3", version, start[7]));

  std::uint64_t length = start[8] | start[9] << 8;
  if (version > 1) length |= std::uint64_t(start[10]) << 16 | std::uint64_t(start[11]) << 24;
  Header header;
  header.data_offset = (version > 1 ? 12u : 10u) + length;
  if (header.data_offset > file_size)
    reject(file, fmt::format("the file is cut off: found {} bytes, expected a header of {}", file_size,
                             header.data_offset));

  if (length > kLongestHeader)
    reject(file, fmt::format("found a header of {} bytes, expected at most {}", length, kLongestHeader));

  std::string dictionary(length, ' ');
  file.read_at(header.data_offset - length, dictionary);
  std::string_view text = dictionary;
  text.remove_prefix(std::min(text.find('{') + 1, text.size()));
  while (!text.empty()) {
    const std::string key = unquoted(take_value(text));
    if (key == "descr") header.descr = unquoted(take_value(text));
    if (key == "fortran_order") header.fortran_order = take_value(text);
    if (key == "shape") header.shape = take_value(text);
  }
  const bool has_order = header.fortran_order == "True" || header.fortran_order == "False";
  if (header.descr.empty() || header.shape.empty() || !has_order)
    reject(file, "the NPY header is broken, expected descr, fortran_order (True or False) and shape");
  return header;
}

void write_header(OutputFile& file, std::string_view descr, std::string_view shape) {
  std::string header = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", descr, shape);
  constexpr std::size_t kPreamble = 10, kAlignment = 64;
  header.append(kAlignment - (kPreamble + header.size() + 1) % kAlignment, ' ');
  header += '\n';
  const std::array<char, 4> version_and_length = {1, 0, char(header.size() & 0xff), char(header.size() >> 8)};
  file.write(kMagic);
  file.write({version_and_length.data(), version_and_length.size()});
  file.write(header);
}

}  // namespace boxunion::npy

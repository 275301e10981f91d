#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "host/files/formats.hpp"
#include "host/files/volume_header.hpp"
#include "host/files/voxel_data.hpp"

// The format: https://teem.sourceforge.net/nrrd/format.html

namespace boxunion::nrrd {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if ('A' <= c && c <= 'Z') c = char(c + 'a' - 'A');
  return result;
}

/// Reads the lines up to the blank line that ends an attached header.
VolumeHeader read_header(std::shared_ptr<const InputFile> file) {
  VolumeHeader header(std::move(file));
  const auto magic = header.take_line();
  if (!magic || magic->size() != 8 || !magic->starts_with("NRRD000") || (*magic)[7] < '1' ||
      (*magic)[7] > '5')
    reject(header.file(), "not an NRRD file, expected it to start with a line NRRD0001 to NRRD0005");
  while (const auto line = header.take_line()) {
    if (line->empty()) break;
    if (line->starts_with('#') || line->find(":=") != line->npos) continue;
    const std::size_t colon = line->find(": ");
    if (colon == line->npos)
      reject(header.file(),
             fmt::format("the header has a line \"{}\", expected \"field: value\"", shortened(*line)));
    std::string field = lower(line->substr(0, colon));
    std::erase(field, ' ');  // both "data file" and "datafile" are written
    header.add(field, trimmed(line->substr(colon + 2)));
  }
  return header;
}

Element element_of(const VolumeHeader& header) {
  static const std::map<std::string, Element, std::less<>> kTypes = {
      {"signed char", Element::i8},
      {"int8", Element::i8},
      {"int8_t", Element::i8},
      {"uchar", Element::u8},
      {"unsigned char", Element::u8},
      {"uint8", Element::u8},
      {"uint8_t", Element::u8},
      {"short", Element::i16},
      {"short int", Element::i16},
      {"signed short", Element::i16},
      {"signed short int", Element::i16},
      {"int16", Element::i16},
      {"int16_t", Element::i16},
      {"ushort", Element::u16},
      {"unsigned short", Element::u16},
      {"unsigned short int", Element::u16},
      {"uint16", Element::u16},
      {"uint16_t", Element::u16},
      {"int", Element::i32},
      {"signed int", Element::i32},
      {"int32", Element::i32},
      {"int32_t", Element::i32},
      {"uint", Element::u32},
      {"unsigned int", Element::u32},
      {"uint32", Element::u32},
      {"uint32_t", Element::u32},
      {"longlong", Element::i64},
      {"long long", Element::i64},
      {"long long int", Element::i64},
      {"signed long long", Element::i64},
      {"signed long long int", Element::i64},
      {"int64", Element::i64},
      {"int64_t", Element::i64},
      {"ulonglong", Element::u64},
      {"unsigned long long", Element::u64},
      {"unsigned long long int", Element::u64},
      {"uint64", Element::u64},
      {"uint64_t", Element::u64},
      {"float", Element::f32},
      {"double", Element::f64},
  };
  const auto found = kTypes.find(lower(shortened(header.get("type"))));
  if (found == kTypes.end())
    reject(header.file(),
           fmt::format("found numbers of type {}, expected integers of 8 to 64 bits, float or double",
                       shortened(header.get("type"))));
  return found->second;
}

/// The number for each axis in a field. "nan" means that the numbers are unknown.
std::array<double, 3> per_axis(const VolumeHeader& header, const std::string& field, double unknown) {
  const std::string* value = header.find(field);
  if (!value) return {unknown, unknown, unknown};
  if (lower(*value) == "nan nan nan") return {unknown, unknown, unknown};
  const auto numbers = header.numbers(field, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

/// Places the axes by their directions in space, or otherwise by their spacings and minima.
void place(const VolumeHeader& header, VoxelGrid& grid) {
  if (header.find("spacedirections")) {
    const auto d = header.numbers("spacedirections", 9);
    const std::array<std::array<double, 3>, 3> steps = {
        {{d[0], d[1], d[2]}, {d[3], d[4], d[5]}, {d[6], d[7], d[8]}}};
    const bool has_origin = header.find("spaceorigin");
    const auto centre = has_origin ? header.numbers("spaceorigin", 3) : std::vector<double>(3);
    header.place(grid, "space directions", steps, {centre[0], centre[1], centre[2]});
    if (!has_origin) grid.origin = {};
    return;
  }
  grid.spacing = per_axis(header, "spacings", 1);
  grid.origin = per_axis(header, "axismins", 0);
  const std::string centers = header.find("centers") ? lower(*header.find("centers")) : "";
  std::string_view rest = centers;
  for (std::size_t a = 0; a < 3; ++a) {
    if (grid.spacing[a] == 0) reject(header.file(), "spacings has a 0, expected other numbers");
    const std::string_view center = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(rest.size(), center.size() + 1));
    if (center == "node" && header.find("axismins")) grid.origin[a] -= grid.spacing[a] / 2;
  }
}

/// The offset behind the next `lines` lines from `offset` on, at most the size of the file.
std::uint64_t skip_lines(const InputFile& file, std::uint64_t offset, std::int64_t lines) {
  const std::uint64_t size = regular_size(file);
  std::array<char, std::size_t{1} << 16> block;
  while (offset < size) {
    const std::size_t got = std::size_t(std::min<std::uint64_t>(block.size(), size - offset));
    file.read_at(offset, std::span(block).first(got));
    for (std::size_t i = 0; i < got; ++i, ++offset)
      if (block[i] == '\n' && --lines == 0) return offset + 1;
  }
  return size;
}

/// The offset of the voxels: skips lines, then bytes. -1 bytes skip everything but the voxels.
std::uint64_t data_offset(const VolumeHeader& header, const InputFile& file, std::uint64_t offset,
                          std::uint64_t bytes, bool is_compressed) {
  const std::uint64_t size = regular_size(file);
  const std::int64_t lines = header.whole("lineskip", 0);
  if (lines < 0) reject(header.file(), fmt::format("line skip is {}, expected at least 0", lines));
  if (lines > 0) offset = skip_lines(file, offset, lines);
  const std::int64_t skip = header.whole("byteskip", 0);
  if (skip < -1 || (skip != 0 && is_compressed))
    reject(header.file(), fmt::format("byte skip is {}, expected {}", skip,
                                      is_compressed ? "0 where voxels are compressed" : "at least -1"));
  if (skip == -1) return size - std::min(size, bytes);
  return offset + std::min(std::uint64_t(skip), size);
}

}  // namespace

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const VolumeOptions& options) {
  const VolumeHeader header = read_header(std::move(file));
  if (const std::int64_t dimension = header.whole("dimension", 0); dimension != 3)
    reject(header.file(), fmt::format("dimension is {}, expected 3", dimension));
  VoxelGrid grid;
  grid.size = header.extents("sizes");
  place(header, grid);

  VoxelData data;
  data.element = element_of(header);
  const std::string encoding = lower(header.get("encoding"));
  data.is_compressed = encoding == "gzip" || encoding == "gz";
  if (!data.is_compressed && encoding != "raw")
    reject(header.file(), fmt::format("found encoding {}, expected raw or gzip", shortened(encoding)));
  if (element_size(data.element) > 1) {
    const std::string endian = lower(header.get("endian"));
    if (endian != "little" && endian != "big")
      reject(header.file(), fmt::format("endian is \"{}\", expected little or big", shortened(endian)));
    data.big_endian = endian == "big";
  }
  const std::string* detached = header.find("datafile");
  if (detached && (detached->starts_with("LIST") || detached->find('%') != detached->npos))
    reject(header.file(),
           fmt::format("data file is \"{}\", expected the name of one file", shortened(*detached)));
  data.file = detached ? header.open_beside(*detached) : header.shared_file();
  data.offset = data_offset(header, *data.file, detached ? 0 : header.position(),
                            grid.voxels() * element_size(data.element), data.is_compressed);
  return stream_voxels(grid, data, options.threshold);
}

}  // namespace boxunion::nrrd

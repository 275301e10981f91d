#include <fmt/format.h>

#include <array>
#include <map>
#include <string>

#include "host/files/formats.hpp"
#include "host/files/volume_header.hpp"
#include "host/files/voxel_data.hpp"

// The format: https://docs.itk.org/en/latest/learn/metaio.html

namespace boxunion::metaimage {
namespace {

/// Reads the lines up to ElementDataFile, the last one.
VolumeHeader read_header(std::shared_ptr<const InputFile> file) {
  VolumeHeader header(std::move(file));
  while (const auto line = header.take_line()) {
    if (trimmed(*line).empty()) continue;
    const std::size_t equals = line->find('=');
    const std::string field(trimmed(line->substr(0, equals)));
    const bool is_name = field.find_first_not_of(
                             "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_") == field.npos;
    if (equals == line->npos || field.empty() || !is_name)
      reject(header.file(), "not a MetaImage file, expected lines \"Field = value\" up to ElementDataFile");
    header.add(field, trimmed(line->substr(equals + 1)));
    if (field == "ElementDataFile") return header;
  }
  reject(header.file(), "not a MetaImage file, expected lines \"Field = value\" up to ElementDataFile");
}

Element element_of(const VolumeHeader& header) {
  static const std::map<std::string, Element, std::less<>> kTypes = {
      {"MET_CHAR", Element::i8},    {"MET_UCHAR", Element::u8},       {"MET_SHORT", Element::i16},
      {"MET_USHORT", Element::u16}, {"MET_INT", Element::i32},        {"MET_UINT", Element::u32},
      {"MET_LONG", Element::i32},   {"MET_ULONG", Element::u32},      {"MET_LONG_LONG", Element::i64},
      {"MET_FLOAT", Element::f32},  {"MET_ULONG_LONG", Element::u64}, {"MET_DOUBLE", Element::f64},
  };
  const auto found = kTypes.find(header.get("ElementType"));
  if (found == kTypes.end())
    reject(header.file(),
           fmt::format("found numbers of type {}, expected MET_CHAR, MET_UCHAR, MET_SHORT, ... or MET_DOUBLE",
                       shortened(header.get("ElementType"))));
  return found->second;
}

bool is_true(const VolumeHeader& header, const std::string& field, bool otherwise) {
  const std::string* value = header.find(field);
  if (!value) return otherwise;
  if (*value == "True" || *value == "true" || *value == "TRUE" || *value == "1") return true;
  if (*value == "False" || *value == "false" || *value == "FALSE" || *value == "0") return false;
  reject(header.file(), fmt::format("{} is \"{}\", expected True or False", field, shortened(*value)));
}

/// The numbers in the first of some fields that is present. The fields are different names for the same
/// thing.
std::vector<double> numbers(const VolumeHeader& header, std::initializer_list<const char*> fields,
                            const std::vector<double>& otherwise) {
  for (const char* field : fields)
    if (header.find(field)) return header.numbers(field, otherwise.size());
  return otherwise;
}

void place(const VolumeHeader& header, VoxelGrid& grid) {
  const auto spacing = numbers(header, {"ElementSpacing", "ElementSize"}, {1, 1, 1});
  const auto centre = numbers(header, {"Offset", "Origin", "Position"}, {0, 0, 0});
  const auto matrix =
      numbers(header, {"TransformMatrix", "Rotation", "Orientation"}, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  std::array<std::array<double, 3>, 3> steps;
  for (std::size_t a = 0; a < 3; ++a) {
    if (spacing[a] == 0) reject(header.file(), "ElementSpacing has a 0, expected other numbers");
    for (std::size_t c = 0; c < 3; ++c) steps[a][c] = matrix[3 * a + c] * spacing[a];
  }
  header.place(grid, "TransformMatrix", steps, {centre[0], centre[1], centre[2]});
}

}  // namespace

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const VolumeOptions& options) {
  const VolumeHeader header = read_header(std::move(file));
  if (const std::int64_t dimensions = header.whole("NDims", 0); dimensions != 3)
    reject(header.file(), fmt::format("NDims is {}, expected 3", dimensions));
  if (const std::int64_t channels = header.whole("ElementNumberOfChannels", 1); channels != 1)
    reject(header.file(), fmt::format("ElementNumberOfChannels is {}, expected 1", channels));
  if (!is_true(header, "BinaryData", true)) reject(header.file(), "BinaryData is False, expected True");
  VoxelGrid grid;
  grid.size = header.extents("DimSize");
  place(header, grid);

  VoxelData data;
  data.element = element_of(header);
  data.big_endian =
      is_true(header, "ElementByteOrderMSB", false) || is_true(header, "BinaryDataByteOrderMSB", false);
  data.is_compressed = is_true(header, "CompressedData", false);
  if (const std::int64_t size = header.whole("CompressedDataSize", 0); data.is_compressed && size > 0)
    data.compressed_size = std::uint64_t(size);
  const std::string& name = header.get("ElementDataFile");
  if (name.empty() || name.starts_with("LIST") || name.find('%') != name.npos)
    reject(header.file(),
           fmt::format("ElementDataFile is \"{}\", expected LOCAL or the name of one file", shortened(name)));
  const bool is_local = name == "LOCAL" || name == "Local" || name == "local";
  data.file = is_local ? header.shared_file() : header.open_beside(name);
  const std::int64_t skip = header.whole("HeaderSize", 0);
  if (skip < -1 || (skip == -1 && data.is_compressed))
    reject(header.file(),
           fmt::format("HeaderSize is {}, expected at least {}", skip, data.is_compressed ? 0 : -1));
  const std::uint64_t size = regular_size(*data.file), bytes = grid.voxels() * element_size(data.element);
  data.offset = skip == -1 ? size - std::min(size, bytes)
                           : (is_local ? header.position() : 0) + std::min(std::uint64_t(skip), size);
  return stream_voxels(grid, data, options.threshold);
}

}  // namespace boxunion::metaimage

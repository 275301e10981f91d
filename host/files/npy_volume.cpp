#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "host/files/formats.hpp"
#include "host/files/npy_header.hpp"
#include "host/files/voxel_data.hpp"

namespace boxunion::npy {
namespace {

VoxelData layout_of(std::shared_ptr<const InputFile> file, const Header& header) {
  static const std::map<std::string, Element, std::less<>> kTypes = {
      {"b1", Element::u8},  {"?", Element::u8},   {"u1", Element::u8},  {"i1", Element::i8},
      {"u2", Element::u16}, {"i2", Element::i16}, {"u4", Element::u32}, {"i4", Element::i32},
      {"u8", Element::u64}, {"i8", Element::i64}, {"f4", Element::f32}, {"f8", Element::f64},
  };
  const char order = header.descr.front();
  const bool has_order = order == '<' || order == '>' || order == '=' || order == '|';
  const auto found = kTypes.find(header.descr.substr(has_order ? 1 : 0));
  if (found == kTypes.end() || (order == '|' && element_size(found->second) > 1))
    reject(*file,
           fmt::format("found voxels of type {}, expected bool, integers of 8 to 64 bits, float32 (f4) or "
                       "float64 (f8)",
                       shortened(header.descr)));
  VoxelData data;
  data.file = std::move(file);
  data.offset = header.data_offset;
  data.element = found->second;
  data.big_endian = order == '>';
  return data;
}

}  // namespace

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const Header& header,
                        const VolumeOptions& options) {
  const VoxelData data = layout_of(std::move(file), header);
  const std::vector<std::uint64_t> shape = header.extents().value();
  VoxelGrid grid;
  grid.size = {shape[2], shape[1], shape[0]};
  check_extents(*data.file, grid.size);
  if (header.is_fortran()) {
    std::swap(grid.size[0], grid.size[2]);
    grid.axes = {2, 1, 0};
  }
  return stream_voxels(grid, data, options.threshold);
}

namespace {

template <class T>
void write_volume(OutputFile& file, const VoxelGrid& grid, std::span<const T> voxels) {
  const auto [nx, ny, nz] = grid.size;
  write_header(file, sizeof(T) == 1 ? "'|u1'" : "'<u4'", fmt::format("({}, {}, {})", nz, ny, nx));
  constexpr std::size_t kAtOnce = std::size_t{1} << 20;  // small, so that an interrupt is noticed soon
  for (; !voxels.empty(); voxels = voxels.subspan(std::min(kAtOnce, voxels.size())))
    file.write_array(voxels.first(std::min(kAtOnce, voxels.size())));
}

}  // namespace

extern const VoxelFormat voxels;
const VoxelFormat voxels = {.bytes = write_volume<std::uint8_t>, .labels = write_volume<std::uint32_t>};

}  // namespace boxunion::npy

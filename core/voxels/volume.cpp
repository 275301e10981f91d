#include "boxunion/volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kVoxelsAtOnce = std::size_t{1} << 22;

}  // namespace

std::size_t slices_at_once(const VoxelGrid& grid) {
  return std::clamp<std::size_t>(kVoxelsAtOnce / std::max<std::size_t>(grid.slice(), 1), 1,
                                 std::max<std::size_t>(grid.size[2], 1));
}

Volume::Volume(const VoxelGrid& size) : grid(size) {
  validate(grid);
  with_memory("the volume", grid.voxels(), [&] { inside.resize(grid.voxels()); });
  parallel_ranges(0, grid.voxels(), kVoxelsAtOnce, [&](std::size_t begin, std::size_t end) {
    std::fill(inside.begin() + std::ptrdiff_t(begin), inside.begin() + std::ptrdiff_t(end), std::uint8_t{0});
  });
}

void validate(const VoxelGrid& grid) {
  std::array<bool, 3> is_there{};
  double voxels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    if (grid.axes[a] > 2 || std::exchange(is_there[grid.axes[a]], true))
      throw Error(ErrorKind::usage,
                  fmt::format("the axes of a volume are {}, {} and {}, expected 0, 1 and 2 in any order",
                              grid.axes[0], grid.axes[1], grid.axes[2]));
    if (grid.size[a] > std::size_t(std::numeric_limits<std::int32_t>::max()))
      throw Error(
          ErrorKind::usage,
          fmt::format("a volume has {} voxels along an axis, expected at most 2147483647", grid.size[a]));
    voxels *= double(grid.size[a]);
  }
  if (voxels > 0x1p60)
    throw Error(ErrorKind::usage, fmt::format("a volume has {} voxels, expected at most 2^60", voxels));
}

void validate(const Volume& volume) {
  validate(volume.grid);
  if (volume.inside.size() != volume.grid.voxels())
    throw Error(ErrorKind::usage, fmt::format("a volume holds {} voxels, expected the {} of its grid",
                                              volume.inside.size(), volume.grid.voxels()));
}

Volume collect(const VoxelStream& stream) {
  const VoxelGrid& grid = stream.grid;
  validate(grid);
  Volume volume;
  volume.grid = grid;
  with_memory("the volume", grid.voxels(), [&] { volume.inside.resize(grid.voxels()); });
  const std::size_t slab = slices_at_once(grid) * grid.slice();
  for (std::size_t done = 0; done < volume.inside.size(); done += slab)
    stream.read(std::span(volume.inside).subspan(done, std::min(slab, volume.inside.size() - done)));
  return volume;
}

VoxelStream stream_of(const Volume& volume) {
  validate(volume);
  return {volume.grid, [&volume, done = std::size_t{0}](std::span<std::uint8_t> slices) mutable {
            if (slices.size() > volume.inside.size() - done)
              throw Error(ErrorKind::usage, "more slices of a volume are read than it has");
            std::copy_n(volume.inside.begin() + std::ptrdiff_t(done), slices.size(), slices.begin());
            done += slices.size();
          }};
}

Volume transposed(const Volume& volume) {
  validate(volume);
  const auto [nx, ny, nz] = volume.grid.size;
  Volume result;
  result.grid = volume.grid;
  std::swap(result.grid.size[0], result.grid.size[2]);
  std::swap(result.grid.origin[0], result.grid.origin[2]);
  std::swap(result.grid.spacing[0], result.grid.spacing[2]);
  std::swap(result.grid.axes[0], result.grid.axes[2]);
  with_memory("the volume", volume.inside.size(), [&] { result.inside.resize(volume.inside.size()); });
  constexpr std::size_t kBlock = 64;  // walks both volumes in cache lines
  parallel_for_each(0, ny, 1, [&, nx = nx, ny = ny, nz = nz](std::size_t y) {
    for (std::size_t block = 0; block < nz; block += kBlock)
      for (std::size_t x = 0; x < nx; ++x)
        for (std::size_t z = block; z < std::min(block + kBlock, nz); ++z)
          result.inside[(x * ny + y) * nz + z] = volume.inside[(z * ny + y) * nx + x];
  });
  return result;
}

}  // namespace boxunion

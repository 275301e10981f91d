#include "core/volume.hpp"

#include <algorithm>
#include <utility>

#include "core/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kVoxelsAtOnce = std::size_t{1} << 22;

}  // namespace

std::size_t slices_at_once(const VoxelGrid& grid) {
  return std::clamp<std::size_t>(kVoxelsAtOnce / std::max<std::size_t>(grid.slice(), 1), 1,
                                 std::max<std::size_t>(grid.size[2], 1));
}

Volume collect(const VoxelStream& stream) {
  const VoxelGrid& grid = stream.grid;
  Volume volume{grid, {}};
  with_memory("the volume", grid.voxels(), [&] { volume.inside.resize(grid.voxels()); });
  const std::size_t slab = slices_at_once(grid) * grid.slice();
  for (std::size_t done = 0; done < volume.inside.size(); done += slab)
    stream.read(std::span(volume.inside).subspan(done, std::min(slab, volume.inside.size() - done)));
  return volume;
}

VoxelStream stream_of(const Volume& volume) {
  return {volume.grid, [&volume, done = std::size_t{0}](std::span<std::uint8_t> slices) mutable {
            std::copy_n(volume.inside.begin() + std::ptrdiff_t(done), slices.size(), slices.begin());
            done += slices.size();
          }};
}

Volume transposed(const Volume& volume) {
  const auto [nx, ny, nz] = volume.grid.size;
  Volume result = {volume.grid, {}};
  std::swap(result.grid.size[0], result.grid.size[2]);
  std::swap(result.grid.origin[0], result.grid.origin[2]);
  std::swap(result.grid.spacing[0], result.grid.spacing[2]);
  std::swap(result.grid.axes[0], result.grid.axes[2]);
  with_memory("the volume", volume.inside.size(), [&] { result.inside.resize(volume.inside.size()); });
  constexpr std::size_t kBlock = 64;  // so that both volumes are walked in cache lines
  parallel_ranges(0, ny, 1, [&, nx = nx, ny = ny, nz = nz](std::size_t first_y, std::size_t last_y) {
    for (std::size_t y = first_y; y < last_y; ++y)
      for (std::size_t block = 0; block < nz; block += kBlock)
        for (std::size_t x = 0; x < nx; ++x)
          for (std::size_t z = block; z < std::min(block + kBlock, nz); ++z)
            result.inside[(x * ny + y) * nz + z] = volume.inside[(z * ny + y) * nx + x];
  });
  return result;
}

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "boxunion/volume.hpp"

namespace boxunion {

/// A volume of unit voxels at the origin. inside(x, y, z) decides about each voxel.
template <class F>
Volume volume_of(std::size_t nx, std::size_t ny, std::size_t nz, F inside) {
  Volume volume;
  volume.grid.size = {nx, ny, nz};
  for (std::size_t z = 0; z < nz; ++z)
    for (std::size_t y = 0; y < ny; ++y)
      for (std::size_t x = 0; x < nx; ++x) volume.inside.push_back(std::uint8_t(inside(x, y, z)));
  return volume;
}

/// Random voxels of random density, in rows shorter and longer than a machine word.
inline Volume random_volume(std::uint32_t seed) {
  std::mt19937 random(seed);
  const std::size_t nx = 1 + random() % (seed % 4 == 0 ? 200 : 9), ny = 1 + random() % 9,
                    nz = 1 + random() % 9;
  const auto density = unsigned(1 + random() % 9);
  return volume_of(nx, ny, nz, [&](auto...) {
    return random() % 10 < density ? std::uint8_t(1 + random() % 255) : std::uint8_t(0);
  });
}

}  // namespace boxunion

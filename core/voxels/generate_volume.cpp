#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;

VoxelGrid make_grid(const std::array<std::int64_t, 3>& size) {
  VoxelGrid grid;
  double voxels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    if (size[a] < 1 || size[a] > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorKind::usage, fmt::format("size is {}, expected 1 to 2147483647", size[a]));
    grid.size[a] = std::size_t(size[a]);
    voxels *= double(size[a]);
  }
  if (voxels > 0x1p60)
    throw Error(ErrorKind::usage, fmt::format("the size makes {} voxels, expected at most 2^60", voxels));
  return grid;
}

Volume make_volume(const VoxelGrid& grid) {
  Volume volume;
  volume.grid = grid;
  with_memory("the volume", grid.voxels(), [&] { volume.inside.resize(grid.voxels()); });
  return volume;
}

/// An ellipsoid. Half axes and centre are in ten-thousandths of half the volume. Cosine and sine of the angle
/// about z are in units of 2^-15.
struct Ellipsoid {
  std::array<std::int64_t, 3> half_axes, centre;
  std::int64_t cosine = 1 << 15, sine = 0;
};
constexpr std::int64_t kCos18 = 31164, kSin18 = 10126;
constexpr std::array<Ellipsoid, 10> kPhantom = {{
    {{6900, 9200, 8100}, {0, 0, 0}},
    {{6624, 8740, 7800}, {0, -184, 0}},
    {{1100, 3100, 2200}, {2200, 0, 0}, kCos18, -kSin18},
    {{1600, 4100, 2800}, {-2200, 0, 0}, kCos18, kSin18},
    {{2100, 2500, 4100}, {0, 3500, -1500}},
    {{460, 460, 500}, {0, 1000, 2500}},
    {{460, 460, 500}, {0, -1000, 2500}},
    {{460, 230, 500}, {-800, -6050, 0}},
    {{230, 230, 200}, {0, -6060, 0}},
    {{230, 460, 200}, {600, -6050, 0}},
}};
constexpr int kUnit = 20;  ///< fractional bits of coordinates

std::int64_t fixed(std::int64_t ten_thousandths) {
  return ten_thousandths * (std::int64_t{1} << kUnit) / 10'000;
}

/// The centre of voxel i of n, from -1 to 1.
std::int64_t centre_of(std::size_t i, std::size_t n) {
  return (2 * std::int64_t(i) + 1 - std::int64_t(n)) * (std::int64_t{1} << kUnit) / std::int64_t(n);
}

std::int64_t square(std::int64_t distance, std::int64_t half_axis) {
  const std::int64_t ratio = (distance * ((std::int64_t{1} << 2 * kUnit) / half_axis)) >> kUnit;
  return ratio * ratio;
}

/// Flips the voxels of row y, z whose centres lie in an ellipsoid.
void flip_row(const Ellipsoid& e, const VoxelGrid& grid, std::size_t y, std::size_t z, std::uint8_t* row) {
  constexpr std::int64_t kOne = std::int64_t{1} << 2 * kUnit;
  const std::int64_t radius = fixed(std::max(e.half_axes[0], e.half_axes[1])) + 1;
  const std::int64_t dy = centre_of(y, grid.size[1]) - fixed(e.centre[1]);
  const std::int64_t dz = square(centre_of(z, grid.size[2]) - fixed(e.centre[2]), fixed(e.half_axes[2]));
  if (dz > kOne || std::abs(dy) > radius) return;
  for (std::size_t x = 0; x < grid.size[0]; ++x) {
    const std::int64_t dx = centre_of(x, grid.size[0]) - fixed(e.centre[0]);
    if (std::abs(dx) > radius) continue;
    const std::int64_t along = (e.cosine * dx + e.sine * dy) >> 15,
                       across = (e.cosine * dy - e.sine * dx) >> 15;
    row[x] ^= square(along, fixed(e.half_axes[0])) + square(across, fixed(e.half_axes[1])) + dz <= kOne;
  }
}

constexpr int kNoiseBits = 24;  ///< the sum of 255 numbers fits 32 bits

/// The `index`-th output of the generator splitmix64 seeded with `seed`.
std::uint64_t splitmix64(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t z = seed + (index + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
  z = (z ^ z >> 27) * 0x94d049bb133111eb;
  return z ^ z >> 31;
}

/// Replaces each of `count` items of `length` numbers, `stride` apart, by the mean of itself and the
/// following window - 1 items. The items wrap around: the first follows the last.
template <class Length>
void average(std::uint32_t* items, std::size_t count, std::size_t stride, Length length, std::size_t window) {
  const std::uint64_t reciprocal = (std::uint64_t{1} << 32) / window;
  std::vector<std::uint32_t> first(window * length), sums(length, 0);
  for (std::size_t i = 0; i < window; ++i)
    for (std::size_t j = 0; j < length; ++j) sums[j] += first[i * length + j] = items[i * stride + j];
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = i + window;
    const std::uint32_t* entering =
        next < count ? items + next * stride : first.data() + (next - count) * length;
    std::uint32_t* item = items + i * stride;
    for (std::size_t j = 0; j < length; ++j) {
      const std::uint32_t sum = sums[j];
      sums[j] = sum - item[j] + entering[j];
      item[j] = std::uint32_t(sum * reciprocal >> 32);
    }
  }
}

/// Averages all numbers along one axis.
void average_axis(Array<std::uint32_t>& noise, const VoxelGrid& grid, std::size_t axis, std::size_t feature) {
  const std::size_t window = std::min(feature, grid.size[axis]);
  if (window == 1) return;
  const auto [nx, ny, nz] = grid.size;
  if (axis == 0) {
    parallel_for_each(0, ny * nz, kGrain / nx + 1, [&, nx = nx](std::size_t row) {
      average(&noise[row * nx], nx, 1, std::integral_constant<std::size_t, 1>{}, window);
    });
  } else {
    // Works on stretches of rows side by side. For z, these continue from one row to the next.
    constexpr std::size_t kStretch = 4096;
    const std::size_t layer = axis == 1 ? nx : nx * ny, layers = grid.size[axis];
    const std::size_t pieces = (layer + kStretch - 1) / kStretch;
    parallel_for_each(0, pieces * (axis == 1 ? nz : 1), 1, [&](std::size_t i) {
      const std::size_t piece = i % pieces * kStretch;
      average(&noise[i / pieces * layer * layers + piece], layers, layer, std::min(kStretch, layer - piece),
              window);
    });
  }
}

/// The lowest bound with at least `rank` numbers below it. All numbers are below 2^kNoiseBits.
std::uint32_t quantile(const Array<std::uint32_t>& noise, std::uint64_t rank) {
  constexpr int kDigit = kNoiseBits / 2;
  std::uint32_t prefix = 0;
  for (const int shift : {kDigit, 0}) {
    using Counts = std::vector<std::uint64_t>;
    const auto count_range = [&](std::size_t begin, std::size_t end, Counts counts) {
      for (std::size_t i = begin; i < end; ++i)
        if (shift == kDigit || noise[i] >> kDigit == prefix)
          ++counts[noise[i] >> shift & ((1u << kDigit) - 1)];
      return counts;
    };
    const auto add = [](Counts a, const Counts& b) {
      for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
      return a;
    };
    const Counts counts = parallel_reduce(0, noise.size(), std::size_t{1} << 22,
                                          Counts(std::size_t{1} << kDigit, 0), count_range, add);
    std::uint32_t digit = 0;
    while (digit < (1u << kDigit) - 1 && rank > counts[digit]) rank -= counts[digit++];
    prefix = prefix << kDigit | digit;
  }
  return rank == 0 ? prefix : prefix + 1;
}

}  // namespace

Volume generate_phantom(const std::array<std::int64_t, 3>& size) {
  Volume volume = make_volume(make_grid(size));
  const VoxelGrid& grid = volume.grid;
  parallel_for_each(0, grid.size[1] * grid.size[2], kGrain / grid.size[0] + 1, [&](std::size_t row) {
    std::uint8_t* const voxels = &volume.inside[row * grid.size[0]];
    std::fill_n(voxels, grid.size[0], std::uint8_t{0});
    for (const Ellipsoid& e : kPhantom) flip_row(e, grid, row % grid.size[1], row / grid.size[1], voxels);
  });
  return volume;
}

Volume generate_porous(const std::array<std::int64_t, 3>& size, const Porosity& porosity,
                       std::uint64_t seed) {
  if (!(porosity.pores >= 0 && porosity.pores <= 1))
    throw Error(ErrorKind::usage, fmt::format("porosity is {}, expected 0 to 1", porosity.pores));
  if (porosity.feature < 1 || porosity.feature > 255)
    throw Error(ErrorKind::usage, fmt::format("feature is {}, expected 1 to 255", porosity.feature));
  const VoxelGrid grid = make_grid(size);
  Array<std::uint32_t> noise;
  with_memory("the noise of the volume", 4 * grid.voxels(), [&] { noise.resize(grid.voxels()); });
  parallel_for_each(0, noise.size(), kGrain, [&](std::size_t i) {
    noise[i] = std::uint32_t(splitmix64(seed, i) >> (64 - kNoiseBits));
  });
  for (int pass = 0; pass < 3; ++pass)
    for (std::size_t axis = 0; axis < 3; ++axis)
      average_axis(noise, grid, axis, std::size_t(porosity.feature));

  const auto rank = std::uint64_t(std::floor(porosity.pores * double(noise.size())));
  const std::uint32_t bound = quantile(noise, rank);
  Volume volume = make_volume(grid);
  parallel_for_each(0, noise.size(), kGrain, [&](std::size_t i) { volume.inside[i] = noise[i] >= bound; });
  return volume;
}

}  // namespace boxunion

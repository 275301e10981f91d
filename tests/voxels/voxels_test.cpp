#include "boxunion/voxels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "core/voxels/voxel_runs.hpp"
#include "tests/files/volumes.hpp"

namespace boxunion {
namespace {

std::vector<IntegerBox> integer_boxes(const Volume& volume) {
  const BoxSet set = voxel_boxes(stream_of(volume));
  return set.visit([]<class T>(const std::vector<BoxOf<T>>& boxes) -> std::vector<IntegerBox> {
    if constexpr (std::is_same_v<T, std::int32_t>) return boxes;
    ADD_FAILURE() << "not integers";
    return {};
  });
}

std::vector<Box> double_boxes(const Volume& volume) {
  const BoxSet set = voxel_boxes(stream_of(volume));
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < set.size(); ++i) boxes.push_back(set[i]);
  return boxes;
}

TEST(VoxelRuns, AreTheMaximalStretchesOfEachRow) {
  for (const std::size_t width : {1u, 7u, 63u, 64u, 65u, 127u, 128u, 129u, 300u})
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(testing::Message() << "width " << width << ", seed " << seed);
      std::mt19937 random(seed);
      const auto stay = unsigned(1 + random() % 20);
      bool is_inside = random() % 2;
      const Volume volume = volume_of(width, 3, 1, [&](auto...) {
        if (random() % stay == 0) is_inside = !is_inside;
        return std::uint8_t(is_inside ? 1u << random() % 8 : 0);
      });
      const VoxelRuns runs(volume.inside, width);
      ASSERT_EQ(runs.rows(), 3u);
      for (std::size_t row = 0; row < 3; ++row) {
        std::vector<std::uint8_t> expected, found(width, 0);
        for (std::size_t x = 0; x < width; ++x) expected.push_back(volume.inside[row * width + x] != 0);
        std::uint32_t last = 0;
        for (const auto& run : runs.row(row)) {
          ASSERT_LT(run.begin, run.end);
          ASSERT_TRUE(run.begin > last || run.begin == 0) << "touches the run before";
          ASSERT_LE(last = run.end, width);
          std::fill(found.begin() + run.begin, found.begin() + run.end, std::uint8_t{1});
        }
        EXPECT_EQ(found, expected);
      }
    }
}

TEST(VoxelBoxes, CoverEachVoxelInsideOnceAndRepeatNoNeighbor) {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Volume volume = random_volume(seed);
    const auto [nx, ny, nz] = volume.grid.size;
    std::vector<int> count(volume.inside.size());
    const std::vector<IntegerBox> boxes = integer_boxes(volume);
    for (const IntegerBox& b : boxes)
      for (int z = b[2]; z < b[5]; ++z)
        for (int y = b[1]; y < b[4]; ++y)
          for (int x = b[0]; x < b[3]; ++x)
            ++count[(std::size_t(z) * ny + std::size_t(y)) * nx + std::size_t(x)];
    for (std::size_t i = 0; i < count.size(); ++i) ASSERT_EQ(count[i], volume.inside[i] != 0);
    for (const IntegerBox& a : boxes)
      for (const IntegerBox& b : boxes)
        ASSERT_FALSE(a[0] == b[0] && a[3] == b[3] && a[1] == b[1] && a[4] == b[4] && a[5] == b[2])
            << "the same slice twice";
    ASSERT_TRUE(std::is_sorted(boxes.begin(), boxes.end(), [](const IntegerBox& a, const IntegerBox& b) {
      return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
    }));
  }
}

TEST(VoxelBoxes, OfKnownShapesAreAsFewAsTheDecompositionMakes) {
  EXPECT_EQ(integer_boxes(volume_of(5, 4, 3, [](auto...) { return 1; })),
            (std::vector<IntegerBox>{{0, 0, 0, 5, 4, 3}}));
  EXPECT_TRUE(integer_boxes(volume_of(5, 4, 3, [](auto...) { return 0; })).empty());
  EXPECT_EQ(integer_boxes(volume_of(4, 4, 4, [](auto x, auto y, auto z) { return (x + y + z) % 2; })).size(),
            32u);
  // A step: rows of two widths, each through all slices.
  EXPECT_EQ(integer_boxes(volume_of(4, 4, 2, [](auto x, auto y, auto) { return x < (y < 2 ? 4u : 1u); })),
            (std::vector<IntegerBox>{{0, 0, 0, 4, 2, 2}, {0, 2, 0, 1, 4, 2}}));
}

TEST(VoxelBoxes, ContinueAcrossSlabs) {
  // Slices so large that each is a slab of its own. A bar runs along z, with one more voxel in another slice.
  Volume volume = volume_of(2500, 2000, 4, [](auto x, auto, auto) { return x == 3; });
  ASSERT_EQ(slices_at_once(volume.grid), 1u);
  volume.inside[volume.grid.slice() + 4] = 1;
  EXPECT_EQ(integer_boxes(volume),
            (std::vector<IntegerBox>{
                {3, 0, 0, 4, 2000, 1}, {3, 0, 1, 5, 1, 2}, {3, 1, 1, 4, 2000, 2}, {3, 0, 2, 4, 2000, 4}}));
}

TEST(VoxelBoxes, LieWhereTheGridSays) {
  Volume volume = volume_of(3, 2, 1, [](auto x, auto, auto) { return x > 0; });
  volume.grid.origin = {10, -20, 30};
  EXPECT_EQ(integer_boxes(volume), (std::vector<IntegerBox>{{11, -20, 30, 13, -18, 31}}));
  volume.grid.spacing = {-2, 1, 3};
  EXPECT_EQ(integer_boxes(volume), (std::vector<IntegerBox>{{4, -20, 30, 8, -18, 33}}));
  volume.grid.axes = {2, 0, 1};
  EXPECT_EQ(integer_boxes(volume), (std::vector<IntegerBox>{{-20, 30, 4, -18, 33, 8}}));
  volume.grid.spacing = {0.1, 1, 3};
  EXPECT_EQ(double_boxes(volume), (std::vector<Box>{{-20, 30, 10.1, -18, 33, 10.3}}));
  volume.grid.axes = {0, 1, 2};
  volume.grid.spacing = {1, 1, 1};
  volume.grid.origin = {2147483645, 0, 0};
  EXPECT_EQ(double_boxes(volume), (std::vector<Box>{{2147483646, 0, 0, 2147483648, 2, 1}}));
  volume.grid.origin = {0, 1.7e308, 0};
  volume.grid.spacing[1] = 1e308;
  EXPECT_THROW(voxel_boxes(stream_of(volume)), Error);
}

TEST(VoxelBoxes, HaveTheVolumeAndAreaOfTheVoxels) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Volume volume = random_volume(seed);
    const auto [nx, ny, nz] = volume.grid.size;
    const auto at = [&, nx = nx, ny = ny, nz = nz](std::size_t x, std::size_t y, std::size_t z) {
      return x < nx && y < ny && z < nz && volume.inside[(z * ny + y) * nx + x];
    };
    int voxels = 0, faces = 0;
    for (std::size_t z = 0; z <= nz; ++z)
      for (std::size_t y = 0; y <= ny; ++y)
        for (std::size_t x = 0; x <= nx; ++x) {
          voxels += at(x, y, z);
          faces += (at(x, y, z) != at(x - 1, y, z)) + (at(x, y, z) != at(x, y - 1, z)) +
                   (at(x, y, z) != at(x, y, z - 1));
        }
    const MassProperties mass = measure(voxel_boxes(stream_of(volume)), {.device = "native"});
    EXPECT_EQ(mass.volume, voxels);
    EXPECT_EQ(mass.area, faces);
  }
}

TEST(VoxelBoxes, AreTheSameWhenStreamed) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Volume volume =
        seed == 0 ? generate_porous({200, 150, 100}, {.pores = 0.5, .feature = 2}, 1) : random_volume(seed);
    if (seed % 2) volume.grid.spacing = {0.5, -0.1, 3};
    std::vector<Box> expected = double_boxes(volume), found;
    bool are_doubles = false;
    stream_voxel_boxes(stream_of(volume), [&](const BoxSet& boxes) {
      for (std::size_t i = 0; i < boxes.size(); ++i) found.push_back(boxes[i]);
      are_doubles = boxes.visit([]<class T>(const std::vector<BoxOf<T>>&) { return sizeof(T) == 8; });
    });
    EXPECT_EQ(are_doubles, seed % 2 == 1);
    std::ranges::sort(expected);
    std::ranges::sort(found);
    EXPECT_TRUE(found == expected);
  }
}

struct Labelled {
  std::vector<std::uint32_t> labels;
  std::vector<VoxelComponent> components;
};

Labelled label(const Volume& volume, Connectivity connectivity) {
  Labelled result;
  result.labels.resize(volume.inside.size(), 77);
  result.components = label_voxels(volume, connectivity, result.labels);
  return result;
}

/// Labels each voxel without a label by a flood fill.
Labelled flood(const Volume& volume, Connectivity connectivity) {
  const auto [nx, ny, nz] = volume.grid.size;
  Labelled result;
  result.labels.resize(volume.inside.size());
  const auto index = [nx = nx, ny = ny](std::array<std::uint32_t, 3> p) {
    return (p[2] * ny + p[1]) * nx + p[0];
  };
  for (std::uint32_t z = 0; z < nz; ++z)
    for (std::uint32_t y = 0; y < ny; ++y)
      for (std::uint32_t x = 0; x < nx; ++x) {
        if (!volume.inside[index({x, y, z})] || result.labels[index({x, y, z})]) continue;
        VoxelComponent component{0, {x, y, z}, {x, y, z}};
        const auto label = std::uint32_t(result.components.size() + 1);
        std::vector<std::array<std::uint32_t, 3>> front = {{x, y, z}};
        result.labels[index(front[0])] = label;
        while (!front.empty()) {
          const auto p = front.back();
          front.pop_back();
          ++component.voxels;
          for (std::size_t a = 0; a < 3; ++a) {
            component.first[a] = std::min(component.first[a], p[a]);
            component.last[a] = std::max(component.last[a], p[a]);
          }
          for (unsigned n = 0; n < 27; ++n) {
            const std::array<unsigned, 3> step = {n % 3, n / 3 % 3, n / 9};
            if (connectivity == Connectivity::faces && (step[0] == 1) + (step[1] == 1) + (step[2] == 1) != 2)
              continue;
            std::array<std::uint32_t, 3> q;
            for (std::size_t a = 0; a < 3; ++a) q[a] = p[a] + step[a] - 1;
            if (q[0] >= nx || q[1] >= ny || q[2] >= nz || !volume.inside[index(q)] || result.labels[index(q)])
              continue;
            result.labels[index(q)] = label;
            front.push_back(q);
          }
        }
        result.components.push_back(component);
      }
  return result;
}

TEST(VoxelLabels, AreThoseOfAFloodFromEveryVoxel) {
  for (std::uint32_t seed = 0; seed < 500; ++seed)
    for (const auto connectivity : {Connectivity::faces, Connectivity::points}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", connectivity " << int(connectivity));
      const Volume volume = random_volume(seed);
      const Labelled found = label(volume, connectivity), expected = flood(volume, connectivity);
      ASSERT_EQ(found.labels, expected.labels);
      ASSERT_EQ(found.components, expected.components);
    }
}

TEST(VoxelLabels, OfALargePorousBlockDoNotDependOnItsParts) {
  // Many components that cross the parts on which threads work.
  const Volume volume = generate_porous({150, 140, 130}, {.pores = 0.85, .feature = 3}, 4);
  for (const auto connectivity : {Connectivity::faces, Connectivity::points}) {
    const Labelled expected = flood(volume, connectivity);
    EXPECT_GT(expected.components.size(), 100u);
    for (int again = 0; again < 3; ++again) {
      const Labelled found = label(volume, connectivity);
      ASSERT_EQ(found.labels, expected.labels);
      ASSERT_EQ(found.components, expected.components);
    }
  }
}

TEST(VoxelLabels, TellCornersAndEdgesFromFaces) {
  const auto count = [](const Volume& volume, Connectivity connectivity) {
    return label(volume, connectivity).components.size();
  };
  const Volume checkerboard = volume_of(9, 8, 7, [](auto x, auto y, auto z) { return (x + y + z) % 2 == 0; });
  EXPECT_EQ(count(checkerboard, Connectivity::faces), 252u);
  EXPECT_EQ(count(checkerboard, Connectivity::points), 1u);
  const Volume apart =
      volume_of(9, 9, 9, [](auto x, auto y, auto z) { return x % 2 == 0 && y % 2 == 0 && z % 2 == 0; });
  EXPECT_EQ(count(apart, Connectivity::points), 125u);
}

TEST(GenerateVolume, APorousBlockHasTheRequestedPorosity) {
  for (const double pores : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const Volume volume = generate_porous({64, 50, 70}, {.pores = pores, .feature = 5}, 1);
    const auto solid = std::size_t(std::count(volume.inside.begin(), volume.inside.end(), 1));
    EXPECT_NEAR(double(solid) / double(volume.inside.size()), 1 - pores, 0.001) << pores;
  }
}

TEST(GenerateVolume, AWiderFeatureMakesFewerBoxes) {
  std::size_t boxes = std::size_t(-1);
  for (const std::int64_t feature : {1, 3, 9, 27}) {
    const std::size_t fewer =
        integer_boxes(generate_porous({60, 60, 60}, {.pores = 0.5, .feature = feature}, 1)).size();
    EXPECT_LT(fewer, boxes) << feature;
    boxes = fewer;
  }
}

/// FNV-1a. These volumes are the same on every machine.
std::uint64_t checksum(const Volume& volume) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint8_t byte : volume.inside) hash = (hash ^ byte) * 0x100000001b3;
  return hash;
}

TEST(GenerateVolume, IsTheSameEverywhere) {
  EXPECT_EQ(checksum(generate_porous({40, 30, 20}, {.pores = 0.6, .feature = 4}, 7)), 15443167259470841619u);
  EXPECT_EQ(checksum(generate_phantom({40, 50, 60})), 4993618521428957259u);
  EXPECT_NE(checksum(generate_porous({40, 30, 20}, {.pores = 0.6, .feature = 4}, 7)),
            checksum(generate_porous({40, 30, 20}, {.pores = 0.6, .feature = 4}, 8)));
}

TEST(GenerateVolume, ThePhantomIsAShellRoundSeparateBodies) {
  const Volume phantom = generate_phantom({100, 100, 100});
  const Labelled solid = label(phantom, Connectivity::faces);
  ASSERT_GE(solid.components.size(), 5u);
  EXPECT_NEAR(double(solid.components[0].last[0] - solid.components[0].first[0] + 1), 69, 1);
  EXPECT_NEAR(double(solid.components[0].last[1] - solid.components[0].first[1] + 1), 92, 1);
  EXPECT_NEAR(double(solid.components[0].last[2] - solid.components[0].first[2] + 1), 81, 1);
}

TEST(GenerateVolume, ParametersOutOfRangeAreUsageErrors) {
  const std::int64_t huge = std::int64_t{1} << 31;
  EXPECT_THROW(generate_phantom({0, 1, 1}), Error);
  EXPECT_THROW(generate_phantom({1, huge, 1}), Error);
  EXPECT_THROW(generate_phantom({huge - 1, huge - 1, huge - 1}), Error);
  EXPECT_THROW(generate_porous({1, 1, 1}, {.pores = 1.01}, 1), Error);
  EXPECT_THROW(generate_porous({1, 1, 1}, {.pores = std::numeric_limits<double>::quiet_NaN()}, 1), Error);
  EXPECT_THROW(generate_porous({1, 1, 1}, {.feature = 0}, 1), Error);
  EXPECT_THROW(generate_porous({1, 1, 1}, {.feature = 256}, 1), Error);
}

}  // namespace
}  // namespace boxunion

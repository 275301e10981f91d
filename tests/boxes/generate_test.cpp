#include "boxunion/generate.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

TEST(Generate, CubesDrawXThenYThenZ) {
  std::mt19937_64 random(12345);
  for (const IntegerBox& cube : collect(generate_cubes(1000, 48, 32768, 12345)))
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(cube[axis], std::int32_t(random() % (32768 - 48 + 1)));
      EXPECT_EQ(cube[axis + 3], cube[axis] + 48);
    }
}

TEST(Generate, BoxesStayInTheUniverseWithTheirEdges) {
  std::set<std::int32_t> edges;
  for (const IntegerBox& box : collect(generate_boxes(10'000, 0, 3, 5, 1)))
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_GE(box[axis], 0);
      EXPECT_LE(box[axis + 3], 5);
      edges.insert(box[axis + 3] - box[axis]);
    }
  EXPECT_EQ(edges, (std::set<std::int32_t>{0, 1, 2, 3}));
}

TEST(Generate, CountsAreThoseOfTheBoxes) {
  for (const auto& [generator, count] : {std::pair{generate_checkerboard(20), 4000u},
                                         {generate_checkerboard(3), 14u},
                                         {generate_sponge(0), 1u},
                                         {generate_sponge(3), 8000u},
                                         {generate_cubes(200'000, 1, 9, 1), 200'000u},
                                         {generate_cubes(0, 1, 9, 1), 0u}}) {
    EXPECT_EQ(generator.count, count);
    EXPECT_EQ(collect(generator).size(), count);
  }
}

TEST(Generate, TheSpongeHasHolesAndNoCubeTwice) {
  const auto cubes = collect(generate_sponge(2));
  EXPECT_EQ(std::set(cubes.begin(), cubes.end()).size(), 400u);
  for (const IntegerBox& c : cubes)
    for (const int scale : {1, 3})
      EXPECT_LT((c[0] / scale % 3 == 1) + (c[1] / scale % 3 == 1) + (c[2] / scale % 3 == 1), 2);
}

TEST(Generate, ARunIsRepeatable) {
  const BoxGenerator generator = generate_cubes(100, 2, 50, 7);
  EXPECT_EQ(collect(generator), collect(generator));
  EXPECT_NE(collect(generator), collect(generate_cubes(100, 2, 50, 8)));
}

TEST(Generate, ParametersOutOfRangeAreUsageErrors) {
  EXPECT_THROW(generate_cubes(1, 0, 9, 1), Error);
  EXPECT_THROW(generate_cubes(1, 10, 9, 1), Error);
  EXPECT_THROW(generate_cubes(1, 1, std::int64_t{1} << 31, 1), Error);
  EXPECT_THROW(generate_boxes(1, 3, 2, 9, 1), Error);
  EXPECT_THROW(generate_checkerboard(0), Error);
  EXPECT_THROW(generate_sponge(15), Error);
}

}  // namespace
}  // namespace boxunion

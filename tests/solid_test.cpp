#include "core/solid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace boxunion {
namespace {

TEST(Solid, TakesBatchesFromAnyThreadAndSortsThem) {
  std::vector<Vertex> sorted;
  for (std::uint32_t i = 0; i < 20'000; ++i) sorted.push_back({i % 10, i / 10 % 10, i / 100, 1 + i % 7});
  std::vector<Vertex> shuffled = sorted;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));

  SolidSink sink;
  parallel_ranges(0, shuffled.size(), 50, [&](std::size_t begin, std::size_t end) {
    sink.add(std::span(shuffled).subspan(begin, end - begin));
  });
  const Axis axis = Axis::lattice(0, 0, 200);
  const Solid solid = sink.take({axis, axis, axis});
  EXPECT_EQ(solid.vertices, sorted);
  EXPECT_EQ(solid.axes[2].count(), 200u);
  EXPECT_TRUE(sink.take({}).vertices.empty());
}

}  // namespace
}  // namespace boxunion

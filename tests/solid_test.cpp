#include "core/solid.hpp"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <random>

namespace boxunion {
namespace {

TEST(Solid, TakesBatchesFromAnyThreadAndSortsThem) {
  Array<Vertex> sorted;
  for (std::uint32_t i = 0; i < 20'000; ++i) sorted.push_back({i % 10, i / 10 % 10, i / 100, 1 + i % 7});
  Array<Vertex> shuffled = sorted;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));

  const Axis axis = Axis::lattice(0, 0, 200);
  SolidSink sink({axis, axis, axis});
  parallel_ranges(0, shuffled.size(), 50, [&](std::size_t begin, std::size_t end) {
    sink.add(std::span(shuffled).subspan(begin, end - begin));
  });
  const Solid solid = sink.take();
  EXPECT_EQ(solid.vertices, sorted);
  EXPECT_EQ(solid.axes[2].count(), 200u);
  EXPECT_TRUE(sink.take().vertices.empty());
}

TEST(Solid, SortsAnyNumberOfVerticesOnAnyNumberOfThreads) {
  for (const std::size_t count : {0, 1, 2, 32, 33, 1000, 1'000'000})
    for (const std::uint32_t widest : {0u, 99u, 0xfffffffeu})
      for (const int threads : {1, 2, 5}) {
        std::mt19937 random(widest);
        Array<Vertex> vertices(count);
        for (std::uint32_t i = 0; i < count; ++i) {  // all differ
          const auto ordinal = static_cast<std::uint32_t>(random() & widest);
          vertices[i] = {i, ordinal, ordinal ^ 1u, 1 + i % 7};
        }
        std::shuffle(vertices.begin(), vertices.end(), random);
        const auto axis = [](std::uint64_t most) { return Axis::lattice(0, 0, std::uint32_t(most)); };
        SolidSink sink({axis(count), axis(widest), axis(widest | 1u)});
        sink.add(vertices);
        std::sort(vertices.begin(), vertices.end());
        tbb::task_arena(threads).execute([&] { EXPECT_TRUE(sink.take().vertices == vertices); });
      }
}

}  // namespace
}  // namespace boxunion

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/solid/solid_sink.hpp"

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

TEST(VertexCode, HasRoomFor56BitsOfOrdinals) {
  const auto code = [](std::array<std::uint32_t, 3> most) {
    return VertexCode(
        {Axis::lattice(0, 0, most[0]), Axis::lattice(0, 0, most[1]), Axis::lattice(0, 0, most[2])});
  };
  constexpr std::uint32_t k19 = (1u << 19) - 1, k18 = (1u << 18) - 1;
  for (const std::array<std::uint32_t, 3>& most : {std::array{k19, k19, k18},
                                                   {k19, k18, k19},
                                                   {k18, k19, k19},
                                                   {0xfffffffeu, 1u, k19},
                                                   {1u, 1u, 0xfffffffeu}}) {
    EXPECT_TRUE(code(most).fits());
    const Vertex first{1, 1, 1, 1}, last{most[0], most[1], most[2], 254};
    EXPECT_EQ(code(most).decode(code(most).encode(first)), first);
    EXPECT_EQ(code(most).decode(code(most).encode(last)), last);
    EXPECT_LT(code(most).encode(first), code(most).encode(last));
  }
  for (const unsigned a : {0u, 1u, 2u}) {
    std::array<std::uint32_t, 3> most{k19, k19, k19};
    EXPECT_FALSE(code(most).fits());
    most[a] = k18;
    EXPECT_TRUE(code(most).fits());
    most[a] = k18 + 1;
    EXPECT_FALSE(code(most).fits());
  }
}

TEST(Solid, SortsAnyNumberOfVerticesOnAnyNumberOfThreads) {
  for (const std::size_t count : {0, 1, 2, 32, 33, 1000, 1'000'000})
    for (const std::uint32_t widest : {0u, 99u, 0xfffffffeu})
      for (const int threads : {1, 2, 5}) {
        std::mt19937 random(widest);
        Array<Vertex> vertices(count);
        for (std::uint32_t i = 0; i < count; ++i) {  // all are different
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

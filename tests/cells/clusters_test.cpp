#include "core/cells/clusters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>

#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"

namespace boxunion {
namespace {

using Parts = std::set<std::set<std::uint32_t>>;

/// Clusters found by testing all pairs repeatedly.
Parts brute_force(const std::vector<PackedBox>& boxes) {
  std::vector<std::uint32_t> label(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) label[i] = i;
  const auto touch = [&](std::size_t i, std::size_t j) {
    for (int a = 0; a < 3; ++a)
      if (packed::field(boxes[i].lo, a) > packed::field(boxes[j].hi, a) ||
          packed::field(boxes[j].lo, a) > packed::field(boxes[i].hi, a))
        return false;
    return true;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < boxes.size(); ++i)
      for (std::size_t j = 0; j < boxes.size(); ++j)
        if (label[i] < label[j] && touch(i, j)) label[j] = label[i], changed = true;
  }
  std::map<std::uint32_t, std::set<std::uint32_t>> parts;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) parts[label[i]].insert(i);
  Parts all;
  for (auto& [l, part] : parts) all.insert(part);
  return all;
}

TEST(Clusters, AreTheConnectedComponents) {
  std::mt19937 engine(1);
  const auto random = [&] { return std::uint32_t(engine()); };
  Clusters clusters;
  for (const std::uint32_t edge : {7u, 100u, 4096u, 65536u, 1u << 19})
    for (const std::uint32_t most : {1u, 2u, 8u})  // maximum edge of a box, in eighths of the universe
      for (const std::size_t count : {0u, 1u, 2u, 13u, 60u}) {
        std::vector<PackedBox> boxes(count);
        for (PackedBox& box : boxes) {
          std::uint32_t lo[3], hi[3];
          for (int a = 0; a < 3; ++a) {
            lo[a] = random() % (edge + 1);
            hi[a] = std::min(lo[a] + 1 + random() % std::max(1u, edge / 16 * most), edge + 1);
          }
          box = {packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])};
        }
        if (!clusters.find(boxes, edge)) continue;
        Parts small, expected;
        std::set<std::uint32_t> rest, expected_rest;
        for (const std::uint32_t i : clusters.lone()) small.insert({i});
        std::uint32_t begin = 0;
        for (const std::uint32_t end : clusters.ends()) {
          small.insert({clusters.members().begin() + begin, clusters.members().begin() + end});
          begin = end;
        }
        EXPECT_EQ(begin, clusters.members().size());
        rest.insert(clusters.rest().begin(), clusters.rest().end());
        for (const auto& part : brute_force(boxes))
          if (part.size() <= Clusters::kMostBoxes)
            expected.insert(part);
          else
            expected_rest.insert(part.begin(), part.end());
        EXPECT_EQ(small, expected) << edge << ' ' << most << ' ' << count;
        EXPECT_EQ(rest, expected_rest) << edge << ' ' << most << ' ' << count;
      }
}

TEST(Clusters, AreNotFoundIfAllBoxesMeet) {
  std::vector<PackedBox> boxes(1000, {packed::pack(1, 1, 1), packed::pack(9, 9, 9)});
  EXPECT_FALSE(Clusters().find(boxes, 64));
}

/// Tiles of sums have edges of at most 8192. A box may end, begin or lie across the border of a tile.
TEST(LoneBoxes, CountOnceWhereTilesMeet) {
  for (std::int32_t at = 8186; at < 8198; ++at) {
    const BoxSet boxes(
        std::vector<BoxOf<std::int32_t>>{{0, 0, 0, 1, 1, 1}, {at - 2, at - 2, at - 2, at, at, at}});
    const MassProperties mass = measure(boxes, {.device = "native"});
    EXPECT_EQ(mass.vertices, 16) << at;
    EXPECT_EQ(mass.volume, 9) << at;
    EXPECT_EQ(mass.area, 30) << at;
    EXPECT_EQ(mass.edge_length, 36) << at;
  }
}

/// On each axis, two intervals on 0 .. 3 that touch, in every arrangement.
TEST(Pairs, HaveTheSumsOfTheirVertices) {
  using Interval = std::array<std::int32_t, 2>;
  std::vector<std::array<Interval, 2>> touching;
  for (std::int32_t a = 0; a < 4; ++a)
    for (std::int32_t b = a + 1; b < 4; ++b)
      for (std::int32_t c = 0; c < 4; ++c)
        for (std::int32_t d = c + 1; d < 4; ++d)
          if (a <= d && c <= b) touching.push_back({Interval{a, b}, Interval{c, d}});
  for (const auto& [ax, bx] : touching)
    for (const auto& [ay, by] : touching)
      for (const auto& [az, bz] : touching) {
        const BoxSet boxes(std::vector<BoxOf<std::int32_t>>{{ax[0], ay[0], az[0], ax[1], ay[1], az[1]},
                                                            {bx[0], by[0], bz[0], bx[1], by[1], bz[1]}});
        ASSERT_EQ(measure(boxes, {.device = "native", .threads = 1}),
                  measure(boxes, {.device = "native", .threads = 1, .statistics = true}))
            << testing::PrintToString(boxes[0]) << testing::PrintToString(boxes[1]);
      }
}

TEST(LoneBoxes, HaveTheSumsOfTheirVertices) {
  for (const std::int64_t edge : {20, 300, 900}) {
    const BoxSet boxes = collect(generate_cubes(40'000, edge, 32768, 3));
    // statistics need the vertices
    EXPECT_EQ(measure(boxes, {.device = "native"}), measure(boxes, {.device = "native", .statistics = true}))
        << edge;
  }
}

}  // namespace
}  // namespace boxunion

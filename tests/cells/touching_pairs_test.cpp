#include "core/cells/touching_pairs.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "core/cells/clusters.hpp"

namespace boxunion {
namespace {

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

Pairs brute_force(const std::vector<PackedBox>& boxes) {
  Pairs pairs;
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    for (std::uint32_t j = i + 1; j < boxes.size(); ++j)
      if (packed::all_le(boxes[i].lo, boxes[j].hi) && packed::all_le(boxes[j].lo, boxes[i].hi))
        pairs.emplace(i, j);
  return pairs;
}

/// Boxes with edges of up to most[k % 3] along axis (a + k) % 3. k counts the boxes.
std::vector<PackedBox> random_boxes(std::size_t count, std::uint32_t universe,
                                    const std::array<std::uint32_t, 3>& most, std::mt19937& random) {
  std::vector<PackedBox> boxes(count);
  for (std::size_t k = 0; k < count; ++k) {
    std::uint32_t lo[3], hi[3];
    for (unsigned a = 0; a < 3; ++a) {
      const std::uint32_t edge = 1 + std::uint32_t(random()) % most[(a + k) % 3];
      lo[a] = std::uint32_t(random()) % universe;
      hi[a] = std::min(lo[a] + edge, universe);
    }
    boxes[k] = {packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])};
  }
  return boxes;
}

TEST(TouchingPairs, AreThoseOfBruteForce) {
  std::mt19937 random(4);
  for (const std::uint32_t universe : {1u, 4u, 64u, 4096u, 1u << 19})
    for (const std::array<std::uint32_t, 3>& most :
         {std::array{1u, 1u, 1u}, {1u, 1u, universe}, {2u, universe, universe}, {universe / 8 + 1, 3u, 9u}})
      for (const std::size_t count : {0u, 1u, 2u, 25u, 120u, 700u}) {
        const std::vector<PackedBox> boxes = random_boxes(count, universe, most, random);
        Pairs found;
        EXPECT_TRUE(TouchingPairs().find(boxes, std::size_t(-1), [&](std::uint32_t i, std::uint32_t j) {
          found.emplace(std::min(i, j), std::max(i, j));
        }));
        EXPECT_EQ(found, brute_force(boxes)) << universe << ' ' << most[1] << ' ' << count;
      }
}

TEST(TouchingPairs, GiveUpIfTheyAreMany) {
  const std::vector<PackedBox> boxes(1000, {packed::pack(1, 1, 1), packed::pack(9, 9, 9)});
  std::size_t calls = 0;
  EXPECT_FALSE(TouchingPairs().find(boxes, 4000, [&](std::uint32_t, std::uint32_t) { ++calls; }));
  EXPECT_EQ(calls, 4000u);
}

/// Rods through the whole tile are found one by one. A sweep would compare all rods that run along it.
TEST(Clusters, OfRodsInAllDirectionsAreFound) {
  constexpr std::uint32_t kEdge = 1u << 19;
  std::mt19937 random(5);
  std::vector<PackedBox> boxes;
  for (int i = 0; i < 6000; ++i) {
    std::array<std::uint32_t, 3> lo, hi;
    for (std::uint32_t& c : lo) c = 1 + std::uint32_t(random()) % (kEdge - 2);
    for (unsigned a = 0; a < 3; ++a) hi[a] = lo[a] + 1;
    lo[unsigned(i) % 3] = 1, hi[unsigned(i) % 3] = kEdge;
    boxes.push_back({packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])});
  }
  Clusters clusters;
  ASSERT_TRUE(clusters.find(boxes, kEdge));
  std::set<std::uint32_t> touching;
  for (const auto& [i, j] : brute_force(boxes)) touching.insert({i, j});
  EXPECT_EQ(clusters.lone().size() + touching.size(), boxes.size());
  for (const std::uint32_t i : clusters.lone()) EXPECT_FALSE(touching.contains(i));
}

}  // namespace
}  // namespace boxunion

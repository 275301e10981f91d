#include "core/cells/packed.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace boxunion {
namespace {

std::vector<PackedBox> decoded(const PackedWords& code, const std::vector<std::uint64_t>& words) {
  std::vector<PackedBox> boxes;
  std::uint64_t first = 0;
  PackedBox box;
  for (const std::uint64_t word : words)
    if (code.decode(word, first, box)) boxes.push_back(box);
  EXPECT_EQ(first, 0u);
  return boxes;
}

/// The words of some boxes. Checks that they decode to the same boxes.
std::vector<std::uint64_t> encoded(int log_edge, const std::vector<PackedBox>& boxes) {
  const PackedWords code(log_edge);
  std::vector<std::uint64_t> words;
  for (const PackedBox& box : boxes) code.encode(box, [&](std::uint64_t word) { words.push_back(word); });
  EXPECT_EQ(decoded(code, words), boxes) << "edge 2^" << log_edge;
  return words;
}

TEST(PackedWords, GiveEveryBoxOfASmallTileBack) {
  std::vector<std::array<std::uint32_t, 2>> intervals;
  for (std::uint32_t lo = 0; lo <= 4; ++lo)
    for (std::uint32_t hi = lo + 1; hi <= 5; ++hi) intervals.push_back({lo, hi});
  std::vector<PackedBox> boxes;
  for (const auto& x : intervals)
    for (const auto& y : intervals)
      for (const auto& z : intervals)
        boxes.push_back({packed::pack(x[0], y[0], z[0]), packed::pack(x[1], y[1], z[1])});
  const std::vector<std::uint64_t> words = encoded(2, boxes);
  // One word for boxes that begin in the tile on all axes, as 10 of the 15 intervals do.
  EXPECT_EQ(words.size(), 2 * boxes.size() - 10 * 10 * 10);
}

TEST(PackedWords, GiveBoxesOfTilesOfAnySizeBack) {
  std::mt19937 random(5);
  const auto below = [&](std::uint32_t end) { return std::uint32_t(random() % end); };
  for (int log_edge = 0; log_edge <= 19; ++log_edge) {
    const std::uint32_t edge = 1u << log_edge;
    std::vector<PackedBox> boxes;
    for (int i = 0; i < 3000; ++i) {
      std::array<std::uint32_t, 3> lo, hi;
      for (int a = 0; a < 3; ++a) {
        lo[a] = below(edge + 1);
        const std::uint32_t most = edge + 1 - lo[a];  // short or long
        hi[a] = lo[a] + 1 + below(i % 2 == 0 ? most : std::min(most, 1u << below(20)));
      }
      boxes.push_back({packed::pack(lo[0], lo[1], lo[2]), packed::pack(hi[0], hi[1], hi[2])});
    }
    encoded(log_edge, boxes);
  }
}

TEST(PackedWords, AreOneForAShortBox) {
  const auto words = [](std::uint32_t edge) {
    return encoded(11, {{packed::pack(1, 2048, 7), packed::pack(1 + edge, 2049, 8)}}).size();
  };
  EXPECT_EQ(words(1), 1u);
  EXPECT_EQ(words(1023), 1u);
  EXPECT_EQ(words(1024), 2u);
}

}  // namespace
}  // namespace boxunion

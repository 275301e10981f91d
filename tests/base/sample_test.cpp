#include "core/base/sample.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace boxunion {
namespace {

std::vector<std::uint64_t> positions(std::uint64_t size, std::uint64_t most) {
  std::vector<std::uint64_t> all;
  Sample(size, most).each([&](std::uint64_t i) { all.push_back(i); });
  return all;
}

TEST(Sample, HasOnePositionOfEveryStep) {
  for (std::uint64_t size = 0; size < 200; ++size)
    for (const std::uint64_t most : {1u, 2u, 7u, 64u, 300u}) {
      const std::vector<std::uint64_t> sample = positions(size, most);
      EXPECT_LE(sample.size(), most);
      if (most >= size) {
        EXPECT_EQ(sample.size(), size);
      }
      EXPECT_TRUE(size == 0 || 2 * sample.size() >= std::min(size, most) || sample.size() + 1 >= most);
      for (std::size_t i = 0; i < sample.size(); ++i)
        EXPECT_TRUE(sample[i] < size && (i == 0 || sample[i - 1] < sample[i]));
    }
}

TEST(Sample, IsTheSameInPieces) {
  for (const std::uint64_t piece : {1u, 3u, 100u, 1000u}) {
    std::vector<std::uint64_t> pieces;
    const Sample sample(1000, 37);
    for (std::uint64_t begin = 0; begin < 1000; begin += piece)
      sample.each(begin, std::min<std::uint64_t>(begin + piece, 1000),
                  [&](std::uint64_t i) { pieces.push_back(i); });
    EXPECT_EQ(pieces, positions(1000, 37)) << piece;
  }
}

/// Every kind of element gets its share, even if the input repeats after `period` elements.
TEST(Sample, AgreesWithNoPeriodOfTheInput) {
  for (std::uint64_t size = 1000; size < 100000; size = size * 3 / 2)
    for (const std::uint64_t period : {2u, 3u, 4u, 6u, 8u, 12u}) {
      std::vector<double> share(period);
      const std::vector<std::uint64_t> sample = positions(size, 512);
      for (const std::uint64_t i : sample) share[i % period] += double(period) / double(sample.size());
      EXPECT_GT(*std::ranges::min_element(share), 0.4) << size << ' ' << period;
      EXPECT_LT(*std::ranges::max_element(share), 1.8) << size << ' ' << period;
    }
}

}  // namespace
}  // namespace boxunion

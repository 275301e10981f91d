#include "core/base/ranks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace boxunion {
namespace {

TEST(Ranks, ArePositionsAmongTheDistinctNumbers) {
  Ranks ranks;  // reused
  std::mt19937 random(7);
  for (const std::uint32_t range : {1u, 10u, 5000u, 0xffffffffu})
    for (const std::size_t count : {3000u, 40u, 1u}) {
      std::vector<std::uint32_t> numbers(count);
      for (std::uint32_t& number : numbers) number = std::uint32_t(random() % range);
      ranks.assign(count, [&](std::size_t i) { return numbers[i]; });
      const std::set<std::uint32_t> distinct(numbers.begin(), numbers.end());
      ASSERT_EQ(ranks.distinct(), distinct.size());
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(ranks[i], std::distance(distinct.begin(), distinct.find(numbers[i])));
    }
}

}  // namespace
}  // namespace boxunion

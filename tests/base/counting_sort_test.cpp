#include "core/base/counting_sort.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace boxunion {
namespace {

using Pair = std::pair<std::size_t, std::size_t>;  // key, element

/// Sorts elements with up to three neighboring keys in some chunks, and compares with a loop over all keys.
void sort_and_compare(std::size_t count, std::size_t keys, std::size_t chunks) {
  std::mt19937 random(unsigned(count + 31 * keys + chunks));
  std::vector<std::size_t> first(count), number(count);
  std::vector<Pair> expected;
  for (std::size_t i = 0; i < count; ++i) {
    first[i] = random() % keys;
    number[i] = std::min<std::size_t>(random() % 4, keys - first[i]);
  }
  std::vector<std::uint32_t> expected_ends;
  for (std::size_t key = 0; key < keys; ++key) {
    for (std::size_t i = 0; i < count; ++i)
      if (first[i] <= key && key < first[i] + number[i]) expected.emplace_back(key, i);
    expected_ends.push_back(std::uint32_t(expected.size()));
  }

  const auto keys_of = [&](std::size_t i, auto&& f) {
    for (std::size_t n = 0; n < number[i]; ++n) f(first[i] + n);
  };
  CountingSort<std::uint32_t, decltype(keys_of)> sort(count, keys, chunks, keys_of);
  ASSERT_EQ(sort.size(), expected.size());
  std::vector<std::size_t> elements(sort.size(), count);
  sort.scatter([&](std::size_t i, std::uint32_t place) { elements[place] = i; });
  for (std::size_t place = 0; place < expected.size(); ++place)
    EXPECT_EQ(elements[place], expected[place].second) << place;
  EXPECT_EQ(std::vector<std::uint32_t>(sort.ends().begin(), sort.ends().end()), expected_ends);
}

TEST(CountingSort, IsStableWhateverTheChunks) {
  for (const std::size_t count : {1u, 2u, 10u, 1000u})
    for (const std::size_t keys : {1u, 2u, 7u, 300u})
      for (const std::size_t chunks : {1u, 2u, 5u, 16u}) sort_and_compare(count, keys, chunks);
}

TEST(CountingSort, OfNothingIsEmpty) {
  sort_and_compare(0, 3, 1);
}

}  // namespace
}  // namespace boxunion

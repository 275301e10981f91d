#include "core/base/radix_sort.hpp"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace boxunion {
namespace {

TEST(RadixSort, OrderedBitsSortAsDoublesDo) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const std::vector<double> ascending = {-kMost, -1e300, -1.5, -1,  -1e-300, -5e-324, 0.0,
                                         5e-324, 1e-310, 1,    1.5, 1e300,   kMost};
  for (std::size_t i = 0; i < ascending.size(); ++i) {
    EXPECT_EQ(from_ordered_bits(ordered_bits(ascending[i])), ascending[i]);
    if (i > 0) {
      EXPECT_LT(ordered_bits(ascending[i - 1]), ordered_bits(ascending[i]));
    }
  }
  EXPECT_EQ(ordered_bits(-0.0), ordered_bits(0.0));
  EXPECT_FALSE(std::signbit(from_ordered_bits(ordered_bits(-0.0))));
}

template <class Key>
struct Record {
  Key key;
  std::size_t index;
  friend bool operator==(const Record&, const Record&) = default;
};

/// Many keys of a kind, 0 to 5, that may be hard to sort.
template <class Key>
std::vector<Record<Key>> records(std::size_t count, int kind) {
  std::mt19937_64 random(count);
  std::vector<Record<Key>> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    Key key = static_cast<Key>(random());
    if constexpr (sizeof(Key) > 8) key = key << 64 | random();
    if (kind == 1) key %= 7;                              // few distinct
    if (kind == 2) key = 42;                              // all equal
    if (kind == 3) key = static_cast<Key>(i);             // sorted
    if (kind == 4) key = static_cast<Key>(count - i);     // reversed
    if (kind == 5) key >>= random() % (8 * sizeof(Key));  // most of them in few buckets
    result[i] = {key, i};
  }
  return result;
}

template <class Key>
void check(std::size_t count) {
  for (int kind = 0; kind < 6; ++kind) {
    std::vector<Record<Key>> sorted = records<Key>(count, kind), expected = sorted;
    std::ranges::stable_sort(expected, {}, &Record<Key>::key);
    radix_sort(std::span(sorted), [](const Record<Key>& r) { return r.key; });
    EXPECT_TRUE(sorted == expected) << count << " records of kind " << kind;
  }
}

TEST(RadixSort, SortsStablyWhateverTheKeys) {
  for (const std::size_t count :
       {0, 1, 2, 3, 31, 32, 33, 34, 100, 1000, 65'535, 65'536, 131'071, 131'072, 300'000}) {
    check<std::uint32_t>(count);
    check<std::uint64_t>(count);
    check<unsigned __int128>(count);
  }
}

TEST(RadixSort, ThreadsDoNotMatter) {
  for (const int threads : {1, 2, 5})
    tbb::task_arena(threads).execute([] { check<std::uint64_t>(1'000'000); });
}

TEST(RadixSort, SortsMereKeys) {
  std::mt19937 random(3);
  std::vector<std::uint32_t> keys(200'000);
  for (std::uint32_t& key : keys) key = static_cast<std::uint32_t>(random());
  radix_sort(std::span(keys));
  EXPECT_TRUE(std::ranges::is_sorted(keys));
}

}  // namespace
}  // namespace boxunion

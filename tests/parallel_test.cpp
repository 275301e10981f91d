#include "core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>

namespace boxunion {
namespace {

constexpr std::size_t kMany = 1 << 20;

/// How many elements are reached if the flag becomes true with the first of them; throws if that ends the
/// work.
std::size_t reached(std::atomic<bool>& flag, std::size_t grain) {
  std::atomic<std::size_t> count = 0;
  try {
    parallel_ranges(0, kMany, grain, [&](std::size_t begin, std::size_t end) {
      flag = true;
      count += end - begin;
    });
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::interrupted);
    EXPECT_LT(count, kMany);
    throw;
  }
  return count;
}

TEST(Interruptible, EndsWorkThatHasBegun) {
  std::atomic<bool> flag = false;
  const Interruptible scope(&flag);
  EXPECT_THROW(reached(flag, 16), Error);
}

TEST(Interruptible, ReachesWorkWithinWork) {
  std::atomic<bool> flag = false;
  const Interruptible scope(&flag);
  EXPECT_THROW(parallel_ranges(0, 64, 1, [&](std::size_t, std::size_t) { reached(flag, 16); }), Error);
}

TEST(Interruptible, EndsReductions) {
  std::atomic<bool> flag = true;
  const Interruptible scope(&flag);
  EXPECT_THROW(parallel_reduce(
                   0, kMany, 16, 0, [](std::size_t, std::size_t, int sum) { return sum; },
                   [](int a, int b) { return a + b; }),
               Error);
}

TEST(Interruptible, LeavesOtherWorkAlone) {
  std::atomic<bool> flag = false;
  EXPECT_EQ(reached(flag, 16), kMany);
  {
    const Interruptible scope(&flag);
    const Interruptible none(nullptr);
    EXPECT_EQ(reached(flag, 16), kMany);
  }
  EXPECT_EQ(Interruptible::flag(), nullptr);
}

}  // namespace
}  // namespace boxunion

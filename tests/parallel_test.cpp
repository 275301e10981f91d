#include "core/parallel.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <thread>

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

/// How often a thread begins a piece of outer work while it waits for the inner work of another one.
template <class Inner>
int pieces_begun_amid_others(Inner&& inner) {
  PerThread<int> begun(0);
  std::atomic<int> found = 0;
  const tbb::global_control eight(tbb::global_control::max_allowed_parallelism, 8);
  tbb::task_arena(8).execute([&] {
    parallel_ranges(0, 400, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        int& mine = begun.local();
        if (mine++ > 0) ++found;
        inner(i);
        --mine;
      }
    });
  });
  return found;
}

TEST(PerThread, StaysOnesOwnWhileInnerWorkIsWaitedFor) {
  // pieces that take so unlike times that threads run out of them, whatever the number of cores
  const auto rest = [](std::size_t i) {
    std::this_thread::sleep_for(std::chrono::microseconds(i * 7919 % 97 == 0 ? 3000 : 20));
  };
  EXPECT_EQ(pieces_begun_amid_others([&](std::size_t i) {
              parallel_ranges(0, 4, 1, [&](std::size_t begin, std::size_t) { rest(i + begin); });
            }),
            0);
  EXPECT_EQ(pieces_begun_amid_others([&](std::size_t i) {
              parallel_reduce(
                  0, 4, 1, 0,
                  [&](std::size_t begin, std::size_t, int) {
                    rest(i + begin);
                    return 0;
                  },
                  [](int, int) { return 0; });
            }),
            0);
}

}  // namespace
}  // namespace boxunion

#include "core/base/parallel.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace boxunion {
namespace {

constexpr std::size_t kMany = 1 << 20;

/// The number of elements reached if the flag becomes true at the first of them. Throws if that ends the
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

/// If one piece of outer work fails, oneTBB cancels the loops within the others. Each of these must throw
/// instead of returning as if it had run.
TEST(ParallelRanges, ThrowIfTheyDidNotRun) {
  for (int attempt = 0; attempt < 200; ++attempt) {
    std::atomic<int> silent = 0;
    const auto outer = [&](std::size_t begin, std::size_t end) {
      const std::size_t bad = std::size_t(attempt) % 64;
      if (begin <= bad && bad < end) throw Error(ErrorKind::resources, "one of many");
      for (int again = 0; again < 20; ++again) {
        std::atomic<std::size_t> count = 0;
        parallel_ranges(0, 4096, 1, [&](std::size_t first, std::size_t last) { count += last - first; });
        if (count != 4096) ++silent;
      }
    };
    try {
      parallel_ranges(0, 64, 1, outer);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::resources);
    }
    EXPECT_EQ(silent, 0);
  }
}

TEST(ParallelRanges, CallTheHookBeforeEveryPiece) {
  static std::atomic<int> calls;
  static int fail_at;
  const auto hook = [] {
    if (++calls == fail_at) throw std::bad_alloc();
  };
  const auto work = [] {
    parallel_ranges(0, 10, 100, [](std::size_t, std::size_t) {});  // one piece
    parallel_ranges(0, 3, 1, [](std::size_t, std::size_t) {});
  };
  detail::before_piece = hook;
  calls = 0;
  work();
  const int pieces = calls;
  EXPECT_GE(pieces, 2);
  EXPECT_LE(pieces, 4);
  fail_at = 1;
  calls = 0;
  EXPECT_THROW(work(), std::bad_alloc);
  detail::before_piece = nullptr;
}

/// The number of times that a thread begins a piece of outer work while it waits for inner work of another
/// piece.
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

TEST(PerThread, BelongsToItsThreadDuringInnerWork) {
  // the times of the pieces differ so much that threads become idle, whatever the number of cores
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

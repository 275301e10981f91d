#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"

#if defined(__SANITIZE_THREAD__)
#include "core/base/plain_threads.hpp"
#else
#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>
#endif

namespace boxunion {

// The only place where boxunion uses its thread library. The caller decides the number of threads: it runs
// boxunion inside a tbb::task_arena to limit it.
//
// With the thread sanitizer, which cannot see how oneTBB synchronises, it uses plain threads instead.

#if defined(__SANITIZE_THREAD__)
namespace library = plain_threads;
#else
namespace library = tbb;
#endif

/// The number of threads that work at once.
std::size_t thread_count();

// Parallel work may start more parallel work. A thread that waits for work it started does nothing else
// meanwhile, so its PerThread value stays its own.

// A loop either runs over its whole range or throws. Any piece may throw; the output of the loop is then
// invalid.

namespace detail {

/// A function that every piece of parallel work calls first, if set. Tests set it to throw there.
extern std::atomic<void (*)()> before_piece;

inline void begin_piece() {
  Interruptible::check();
  if (const auto call = before_piece.load(std::memory_order_relaxed)) call();
}

/// The body of a loop, independent of its type, so that loops are compiled once. Keeps a reference to its
/// function.
class RangeBody {
 public:
  template <class F>
  explicit RangeBody(F& f)
      : f_(&f), call_([](const void* function, std::size_t begin, std::size_t end) {
          (*static_cast<F*>(const_cast<void*>(function)))(begin, end);
        }) {}
  void operator()(std::size_t begin, std::size_t end) const {
    begin_piece();
    call_(f_, begin, end);
  }

 private:
  const void* f_;
  void (*call_)(const void*, std::size_t, std::size_t);
};

void run_ranges(std::size_t first, std::size_t last, std::size_t grain, RangeBody body);

}  // namespace detail

/// Calls f(begin, end) for ranges that cover [first, last), each of at least `grain` elements if possible.
template <class F>
void parallel_ranges(std::size_t first, std::size_t last, std::size_t grain, F&& f) {
  if (last - first > grain) {
    detail::run_ranges(first, last, grain, detail::RangeBody(f));
  } else if (first < last) {
    detail::begin_piece();
    f(first, last);
  }
}

/// Calls f(i) for each i in [first, last), in ranges of at least `grain` elements if possible.
template <class F>
void parallel_for_each(std::size_t first, std::size_t last, std::size_t grain, F&& f) {
  parallel_ranges(first, last, grain, [&f](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

/// Reduces [first, last). f(begin, end, value) returns the value extended by a range. join combines two
/// values, the earlier one first.
template <class T, class F, class Join>
T parallel_reduce(std::size_t first, std::size_t last, std::size_t grain, T identity, F&& f, Join&& join) {
  constexpr std::size_t kMostParts = 64;
  const std::size_t size = last - first;
  const std::size_t parts = std::clamp(size / grain, std::size_t{1}, kMostParts);
  if (size == 0) return identity;
  std::vector<T> values(parts, identity);
  parallel_ranges(0, parts, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t part = begin; part < end; ++part)
      values[part] =
          f(first + size * part / parts, first + size * (part + 1) / parts, std::move(values[part]));
  });
  for (std::size_t part = 1; part < parts; ++part)
    values[0] = join(std::move(values[0]), std::move(values[part]));
  return std::move(values[0]);
}

/// One T for every thread that asks: T{}, a copy of `init`, or what it returns if it is a function.
template <class T>
class PerThread {
 public:
  PerThread() = default;
  template <class Init>
  explicit PerThread(Init&& init) : values_(std::forward<Init>(init)) {}
  /// This thread's own T.
  T& local() { return values_.local(); }
  /// Calls f(T&) for every T made so far; no thread may be in local() or writing to its T.
  template <class F>
  void for_each(F&& f) {
    for (T& value : values_) f(value);
  }
  template <class F>
  void for_each(F&& f) const {
    for (const T& value : values_) f(value);
  }

 private:
  library::enumerable_thread_specific<T> values_;
};

}  // namespace boxunion

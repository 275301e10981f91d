#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <utility>

#include "core/error.hpp"

#if defined(__SANITIZE_THREAD__)
#include "core/plain_threads.hpp"
#else
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>
#endif

namespace boxunion {

// The one seam between boxunion and its thread library. The number of threads is the caller's business: run
// inside a tbb::task_arena to limit it.
//
// Built with the thread sanitizer, which cannot see how oneTBB synchronises, it uses plain threads instead.

#if defined(__SANITIZE_THREAD__)
namespace library = plain_threads;
#else
namespace library = tbb;
#endif

/// How many threads work at once.
inline std::size_t thread_count() {
  return static_cast<std::size_t>(library::this_task_arena::max_concurrency());
}

/// While it lives, parallel work that its thread starts ends with Error(interrupted) soon after a flag has
/// become true.
class Interruptible {
 public:
  /// `flag` may be null.
  explicit Interruptible(const std::atomic<bool>* flag) : outer_(std::exchange(flag_, flag)) {}
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  ~Interruptible() { flag_ = outer_; }

  /// What the innermost one of this thread watches, or null.
  static const std::atomic<bool>* flag() { return flag_; }
  /// Throws Error(interrupted) if that has become true.
  static void check() {
    if (flag_ && *flag_) throw Error(ErrorKind::interrupted, "interrupted");
  }

 private:
  static inline thread_local const std::atomic<bool>* flag_ = nullptr;
  const std::atomic<bool>* outer_;
};

// Parallel work may start more of it. A thread that waits for what it started does nothing else meanwhile, so
// that what PerThread gave it stays its own.

/// Calls f(begin, end) for ranges that cover [first, last), each of at least `grain` elements where possible.
template <class F>
void parallel_ranges(std::size_t first, std::size_t last, std::size_t grain, F&& f) {
  if (last - first <= grain) {
    if (first < last) f(first, last);
    return;
  }
  const std::atomic<bool>* const flag = Interruptible::flag();
  library::this_task_arena::isolate([&] {
    library::parallel_for(library::blocked_range<std::size_t>(first, last, grain),
                          [&](const library::blocked_range<std::size_t>& r) {
                            if (!flag) return f(r.begin(), r.end());
                            const Interruptible on_this_thread(flag);
                            const std::size_t piece = 8 * grain;
                            for (std::size_t begin = r.begin(); begin < r.end(); begin += piece) {
                              Interruptible::check();
                              f(begin, std::min(begin + piece, r.end()));
                            }
                          });
  });
}

/// Reduces [first, last): f(begin, end, value) returns the value grown by a range, join combines two values.
template <class T, class F, class Join>
T parallel_reduce(std::size_t first, std::size_t last, std::size_t grain, T identity, F&& f, Join&& join) {
  const std::atomic<bool>* const flag = Interruptible::flag();
  return library::this_task_arena::isolate([&] {
    return library::parallel_reduce(
        library::blocked_range<std::size_t>(first, last, grain), identity,
        [&](const library::blocked_range<std::size_t>& r, T value) {
          const Interruptible on_this_thread(flag);
          Interruptible::check();
          return f(r.begin(), r.end(), std::move(value));
        },
        join);
  });
}

/// Sorts [first, last) in ascending order (not stable).
template <class Iterator, class Less = std::less<>>
void parallel_sort(Iterator first, Iterator last, Less less = {}) {
  library::this_task_arena::isolate([&] { library::parallel_sort(first, last, less); });
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

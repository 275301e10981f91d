#pragma once

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace boxunion {

// The one seam between boxunion and its thread library. The number of threads is the caller's business: run
// inside a tbb::task_arena to limit it.

namespace detail {

/// Says to the thread sanitizer, which cannot see into the library, what the library guarantees: all that was
/// done before publish() is there after a later receive().
class Handover {
 public:
#if defined(__SANITIZE_THREAD__)
  void publish() {
    __tsan_release(this);
  }
  void receive() {
    __tsan_acquire(this);
  }

 private:
  char address_ = 0;
#else
  void publish() {}
  void receive() {}
#endif
};

}  // namespace detail

/// Calls f(begin, end) for ranges that cover [first, last), each of at least `grain` elements where possible.
template <class F>
void parallel_ranges(std::size_t first, std::size_t last, std::size_t grain, F&& f) {
  if (last - first <= grain) {
    if (first < last) f(first, last);
    return;
  }
  detail::Handover handover;
  handover.publish();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(first, last, grain),
                    [&](const tbb::blocked_range<std::size_t>& r) {
                      handover.receive();
                      f(r.begin(), r.end());
                      handover.publish();
                    });
  handover.receive();
}

/// Reduces [first, last): f(begin, end, value) returns the value grown by a range, join combines two values.
template <class T, class F, class Join>
T parallel_reduce(std::size_t first, std::size_t last, std::size_t grain, T identity, F&& f, Join&& join) {
  detail::Handover handover;
  handover.publish();
  const auto handed_over = [&](const auto& g, auto&&... arguments) {
    handover.receive();
    T value = g(arguments...);
    handover.publish();
    return value;
  };
  T result = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(first, last, grain), identity,
      [&](const tbb::blocked_range<std::size_t>& r, const T& value) {
        return handed_over(f, r.begin(), r.end(), value);
      },
      [&](const T& a, const T& b) { return handed_over(join, a, b); });
  handover.receive();
  return result;
}

/// Sorts [first, last) in ascending order (not stable).
template <class Iterator, class Less = std::less<>>
void parallel_sort(Iterator first, Iterator last, Less less = {}) {
#if defined(__SANITIZE_THREAD__)
  std::sort(first, last, less);
#else
  tbb::parallel_sort(first, last, less);
#endif
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
  tbb::enumerable_thread_specific<T> values_;
};

}  // namespace boxunion

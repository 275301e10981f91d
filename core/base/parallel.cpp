#include "core/base/parallel.hpp"

#if !defined(__SANITIZE_THREAD__)
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#endif

namespace boxunion {

std::atomic<void (*)()> detail::before_piece = nullptr;

std::size_t thread_count() {
  return static_cast<std::size_t>(library::this_task_arena::max_concurrency());
}

void detail::run_ranges(std::size_t first, std::size_t last, std::size_t grain, RangeBody body) {
  using Range = library::blocked_range<std::size_t>;
  const std::atomic<bool>* const flag = Interruptible::flag();
  library::this_task_arena::isolate([&] {
    library::task_group_context context;
    library::parallel_for(
        Range(first, last, grain),
        [&](const Range& range) {
          if (!flag) return body(range.begin(), range.end());
          const Interruptible on_this_thread(flag);
          const std::size_t piece = 8 * grain;
          for (std::size_t begin = range.begin(); begin < range.end(); begin += piece)
            body(begin, std::min(begin + piece, range.end()));
        },
        context);
    // Where an outer loop fails, oneTBB cancels the loops within it, which then return without having run.
    if (context.is_group_execution_cancelled())
      throw Error(ErrorKind::interrupted, "work around this loop has ended");
  });
}

}  // namespace boxunion

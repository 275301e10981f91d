#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <vector>

// The part of oneTBB that parallel.hpp uses, written simply over std::thread for the thread sanitizer.

namespace boxunion::plain_threads {

template <class T>
class blocked_range {
 public:
  blocked_range(T begin, T end, T grain) : begin_(begin), end_(end), grain_(grain) {}
  T begin() const { return begin_; }
  T end() const { return end_; }
  T grain() const { return grain_; }

 private:
  T begin_, end_, grain_;
};

namespace this_task_arena {
inline int max_concurrency() {
  return 3;
}
/// Isolation needs nothing here: a waiting thread never takes other work.
template <class F>
auto isolate(const F& f) {
  return f();
}
}  // namespace this_task_arena

/// Work that cannot be cancelled: a loop ends early only by an exception of its own.
struct task_group_context {
  bool is_group_execution_cancelled() const { return false; }
};

/// Two helper threads that serve any caller, because starting a thread takes long under the thread sanitizer.
class Helpers {
 public:
  static Helpers& get() {
    static Helpers helpers;
    return helpers;
  }

  /// Calls `work`, and lets idle helpers call it too. `work` must not throw.
  void run(const std::function<void()>& work) {
    Offer offer{&work};
    {
      const std::lock_guard lock(mutex_);
      offers_.push_back(&offer);
    }
    offered_.notify_all();
    work();
    std::unique_lock lock(mutex_);
    std::erase(offers_, &offer);
    done_.wait(lock, [&] { return offer.helpers == 0; });
  }

 private:
  struct Offer {
    const std::function<void()>* work;
    int helpers = 0;
  };

  void help(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (offered_.wait(lock, stop, [&] { return !offers_.empty(); })) {
      Offer& offer = *offers_.back();
      ++offer.helpers;
      lock.unlock();
      (*offer.work)();
      lock.lock();
      // A caller returns from the work only after it has seen that none of it is left.
      std::erase(offers_, &offer);
      if (--offer.helpers == 0) done_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any offered_, done_;
  std::vector<Offer*> offers_;
  std::jthread first_{[this](const std::stop_token& stop) { help(stop); }};
  std::jthread second_{[this](const std::stop_token& stop) { help(stop); }};
};

/// The caller and its helpers share the range in pieces. The first exception reaches the caller.
template <class T, class F>
void parallel_for(const blocked_range<T>& range, const F& f, const task_group_context&) {
  std::atomic<T> next = range.begin();
  std::mutex mutex;
  std::exception_ptr error;
  const T piece = std::max(range.grain(), (range.end() - range.begin()) / 16 + 1);
  Helpers::get().run([&] {
    try {
      for (T begin; (begin = next.fetch_add(piece)) < range.end();)
        f(blocked_range<T>(begin, std::min(begin + piece, range.end()), range.grain()));
    } catch (...) {
      next = range.end();
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
  });
  if (error) std::rethrow_exception(error);
}

template <class T>
class enumerable_thread_specific {
  using Values = std::map<std::thread::id, T>;

 public:
  enumerable_thread_specific() : make_([] { return T{}; }) {}
  template <class Init>
  explicit enumerable_thread_specific(const Init& init) {
    if constexpr (std::is_invocable_v<Init>)
      make_ = init;
    else
      make_ = [init] { return T(init); };
  }
  T& local() {
    const std::lock_guard lock(*mutex_);
    const auto id = std::this_thread::get_id();
    if (const auto found = values_.find(id); found != values_.end()) return found->second;
    return values_.emplace(id, make_()).first->second;
  }

  template <class Iterator>
  struct Each : Iterator {
    auto& operator*() const { return Iterator::operator*().second; }
  };
  auto begin() { return Each<typename Values::iterator>{values_.begin()}; }
  auto end() { return Each<typename Values::iterator>{values_.end()}; }
  auto begin() const { return Each<typename Values::const_iterator>{values_.begin()}; }
  auto end() const { return Each<typename Values::const_iterator>{values_.end()}; }

 private:
  std::function<T()> make_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  Values values_;
};

}  // namespace boxunion::plain_threads

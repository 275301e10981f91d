#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <mutex>
#include <queue>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/parallel.hpp"
#include "host/files/scratch.hpp"

namespace boxunion {

/// Sorts records that do not fit memory, by an external merge sort: each thread writes sorted runs of its
/// records to a scratch file, and the runs are merged at the end.
template <class T, class Less = std::less<T>>
class SortedRuns {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Uses about `bytes` of memory, at most, while so many threads add records.
  SortedRuns(std::uint64_t bytes, std::size_t threads, ScratchFile file, Less less = {})
      : less_(less), most_(std::max(kLeastBuffer, bytes / (threads * sizeof(T)))), file_(std::move(file)) {}

  /// Thread-safe.
  void add(std::span<const T> records);
  void add(const T& record) { add(std::span(&record, 1)); }
  /// The number of records so far. Not while another thread adds.
  std::uint64_t count() const;
  /// Frees the memory for adding. Nothing may be added afterwards.
  void finish();
  /// Calls finish(), then passes all records to f(span) in order, block by block, with about `bytes` of
  /// memory at most. May be called again.
  void merge(std::uint64_t bytes, const std::function<void(std::span<const T>)>& f);

 private:
  static constexpr std::uint64_t kLeastBuffer = 1 << 10, kMostBlock = 1 << 16;  // records

  struct Run {
    std::uint64_t offset, count;
  };

  /// A run in a merge, with one block of it in memory.
  class Reader {
   public:
    Reader(const ScratchFile& file, const Run& run, std::uint64_t block)
        : file_(&file), offset_(run.offset), rest_(run.count), block_(block) {
      refill();
    }
    bool is_done() const { return next_ == records_.size(); }
    const T& front() const { return records_[next_]; }
    void pop() {
      if (++next_ == records_.size()) refill();
    }

   private:
    void refill() {
      records_.resize(std::min(block_, rest_));
      const std::span<T> block = records_;
      file_->read_at(offset_, {reinterpret_cast<char*>(block.data()), block.size_bytes()});
      offset_ += block.size_bytes();
      rest_ -= block.size();
      next_ = 0;
    }

    const ScratchFile* file_;
    std::uint64_t offset_, rest_, block_;  // rest: number of records behind the block
    std::vector<T> records_;
    std::size_t next_ = 0;
  };

  void flush(std::vector<T>& buffer);

  Less less_;
  std::size_t most_;  // records in the buffer of a thread
  ScratchFile file_;
  PerThread<std::vector<T>> buffers_;
  std::mutex mutex_;
  std::vector<Run> runs_;
};

// ---- implementation ----

template <class T, class Less>
void SortedRuns<T, Less>::add(std::span<const T> records) {
  std::vector<T>& buffer = buffers_.local();
  if (buffer.capacity() == 0) buffer.reserve(most_);
  while (!records.empty()) {
    if (buffer.size() == most_) flush(buffer);
    const std::size_t some = std::min(records.size(), most_ - buffer.size());
    buffer.insert(buffer.end(), records.begin(), records.begin() + std::ptrdiff_t(some));
    records = records.subspan(some);
  }
}

template <class T, class Less>
void SortedRuns<T, Less>::flush(std::vector<T>& buffer) {
  if (buffer.empty()) return;
  std::sort(buffer.begin(), buffer.end(), less_);  // on this thread; the others fill their own buffers
  const std::span<const T> run = buffer;
  const std::uint64_t offset = file_.append({reinterpret_cast<const char*>(run.data()), run.size_bytes()});
  const std::lock_guard lock(mutex_);
  runs_.push_back({offset, buffer.size()});
  buffer.clear();
}

template <class T, class Less>
std::uint64_t SortedRuns<T, Less>::count() const {
  std::uint64_t count = file_.size() / sizeof(T);
  buffers_.for_each([&](const std::vector<T>& buffer) { count += buffer.size(); });
  return count;
}

template <class T, class Less>
void SortedRuns<T, Less>::finish() {
  buffers_.for_each([&](std::vector<T>& buffer) {
    flush(buffer);
    buffer = std::vector<T>();  // {} would keep the memory
  });
}

template <class T, class Less>
void SortedRuns<T, Less>::merge(std::uint64_t bytes, const std::function<void(std::span<const T>)>& f) {
  finish();
  const std::uint64_t block =
      std::clamp<std::uint64_t>(bytes / ((runs_.size() + 1) * sizeof(T)), 16, kMostBlock);
  std::vector<Reader> readers;
  readers.reserve(runs_.size());
  const auto later = [&](std::size_t a, std::size_t b) {
    return less_(readers[b].front(), readers[a].front());
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> heads(later);
  for (const Run& run : runs_) {
    readers.emplace_back(file_, run, block);
    heads.push(readers.size() - 1);
  }
  std::vector<T> merged;
  merged.reserve(block);
  while (!heads.empty()) {
    const std::size_t run = heads.top();
    heads.pop();
    // as long as this run is ahead of the others, which is common if records were sorted by region
    do {
      merged.push_back(readers[run].front());
      if (merged.size() == block) {
        f(merged);
        merged.clear();
      }
      readers[run].pop();
    } while (!readers[run].is_done() && (heads.empty() || !later(run, heads.top())));
    if (!readers[run].is_done()) heads.push(run);
  }
  f(merged);
}

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

namespace boxunion {

/// A sorted sequence in which the cost of a change depends neither on its place nor on the length of the
/// sequence. It is kept in chunks; a sequence of at most one chunk is a plain vector.
template <class T>
class SortedChunks {
 public:
  static constexpr std::size_t kMost = 128;  ///< elements per chunk, at most

  /// Where an element is. The end is the place behind the last element.
  struct Place {
    std::size_t chunk = 0, index = 0;
  };

  void clear() {
    chunks_.resize(1);
    chunks_[0].clear();
    size_ = 0;
  }
  std::size_t size() const { return size_; }
  std::size_t bytes() const {
    std::size_t bytes = chunks_.capacity() * sizeof(std::vector<T>);
    for (const std::vector<T>& chunk : chunks_) bytes += chunk.capacity() * sizeof(T);
    return bytes;
  }

  bool is_end(Place p) const { return p.index == chunks_[p.chunk].size(); }
  const T& operator[](Place p) const { return chunks_[p.chunk][p.index]; }
  Place next(Place p) const { return normal({p.chunk, p.index + 1}); }

  /// The first element for which is_before is false. is_before must be true for all elements before that one.
  template <class F>
  Place find(F&& is_before) const {
    const auto is_chunk_before = [&](const std::vector<T>& chunk) { return is_before(chunk.back()); };
    const auto chunk = std::partition_point(chunks_.begin(), chunks_.end() - 1, is_chunk_before);
    const auto element = std::partition_point(chunk->begin(), chunk->end(), is_before);
    return {std::size_t(chunk - chunks_.begin()), std::size_t(element - chunk->begin())};
  }

  /// The same, searching from p on; fast if the element is near.
  template <class F>
  Place find_from(Place p, F&& is_before) const {
    constexpr std::size_t kNear = 8;
    const std::vector<T>& chunk = chunks_[p.chunk];
    for (const std::size_t end = std::min(p.index + kNear, chunk.size()); p.index < end; ++p.index)
      if (!is_before(chunk[p.index])) return p;
    return find(is_before);
  }

  /// Replaces `count` elements from p on by `values`, and returns the place behind them.
  Place replace(Place p, std::size_t count, std::span<const T> values) {
    if (count == 0 && values.size() == 1) return insert_one(p, values.front());
    if (count == 1 && values.empty()) return erase_one(p);
    size_ += values.size() - count;
    const std::size_t both = std::min(count, values.size());
    if (const std::size_t rest = chunks_[p.chunk].size() - p.index; count == values.size() && count < rest) {
      std::copy(values.begin(), values.end(), chunks_[p.chunk].begin() + std::ptrdiff_t(p.index));
      return {p.chunk, p.index + count};
    }
    for (std::size_t i = 0; i < both; ++i, p = next(p)) chunks_[p.chunk][p.index] = values[i];
    for (count -= both; count > 0;) p = erase(p, count);
    return both < values.size() ? insert(p, values.subspan(both)) : p;
  }

  /// Removes the elements for which f is true.
  template <class F>
  void erase_if(F&& f) {
    for (std::vector<T>& chunk : chunks_) size_ -= std::erase_if(chunk, f);
    std::erase_if(chunks_, [](const std::vector<T>& chunk) { return chunk.empty(); });
    if (chunks_.empty()) chunks_.resize(1);
  }

 private:
  /// Most changes are of one element.
  Place insert_one(Place p, const T& value) {
    std::vector<T>& chunk = chunks_[p.chunk];
    if (chunk.size() == chunk.capacity()) chunk.reserve(std::min(kMost + 1, 2 * chunk.size() + 8));
    chunk.insert(chunk.begin() + std::ptrdiff_t(p.index++), value);
    ++size_;
    return normal(chunk.size() > kMost ? split(p) : p);
  }
  Place erase_one(Place p) {
    std::size_t one = 1;
    --size_;
    return erase(p, one);
  }

  /// The end of a chunk other than the last is the begin of the next chunk.
  Place normal(Place p) const {
    return p.index == chunks_[p.chunk].size() && p.chunk + 1 < chunks_.size() ? Place{p.chunk + 1, 0} : p;
  }

  /// Removes those of the `count` elements that are in p's chunk, and subtracts them from `count`.
  Place erase(Place p, std::size_t& count) {
    std::vector<T>& chunk = chunks_[p.chunk];
    const std::size_t some = std::min(count, chunk.size() - p.index);
    chunk.erase(chunk.begin() + std::ptrdiff_t(p.index), chunk.begin() + std::ptrdiff_t(p.index + some));
    count -= some;
    if (!chunk.empty() || chunks_.size() == 1) return normal(p);
    chunks_.erase(chunks_.begin() + std::ptrdiff_t(p.chunk));
    return p.chunk < chunks_.size() ? p : Place{p.chunk - 1, chunks_.back().size()};
  }

  Place insert(Place p, std::span<const T> values) {
    std::vector<T>& chunk = chunks_[p.chunk];
    chunk.insert(chunk.begin() + std::ptrdiff_t(p.index), values.begin(), values.end());
    p.index += values.size();
    if (chunk.size() > kMost) p = split(p);
    return normal(p);
  }

  /// Splits p's chunk into halves, and moves p along.
  Place split(Place p) {
    constexpr std::size_t kHalf = kMost / 2;
    const std::vector<T> whole = std::move(chunks_[p.chunk]);
    std::vector<std::vector<T>> parts;
    for (std::size_t i = 0; i < whole.size(); i += kHalf) {
      std::vector<T>& part = parts.emplace_back();
      part.reserve(kMost + 1);
      part.assign(whole.begin() + std::ptrdiff_t(i),
                  whole.begin() + std::ptrdiff_t(std::min(i + kHalf, whole.size())));
    }
    const auto first = chunks_.begin() + std::ptrdiff_t(p.chunk);
    *first = std::move(parts.front());
    chunks_.insert(first + 1, std::move_iterator(parts.begin() + 1), std::move_iterator(parts.end()));
    const std::size_t part = std::min(p.index / kHalf, parts.size() - 1);
    return {p.chunk + part, p.index - part * kHalf};
  }

  std::vector<std::vector<T>> chunks_ = std::vector<std::vector<T>>(1);  // none is empty, except a single one
  std::size_t size_ = 0;
};

}  // namespace boxunion

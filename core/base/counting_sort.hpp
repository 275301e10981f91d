#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/base/parallel.hpp"

namespace boxunion {

/// A stable counting sort in chunks, shared by threads. An element may have several keys, and comes once for
/// each. The constructor counts; scatter() then passes the place of each element. In between, the caller can
/// make room for size() elements. Index must hold size().
template <class Index, class KeysOf>
class CountingSort {
 public:
  /// keys_of(i, f) calls f(key) for every key of element i < count. Keys are less than `keys`.
  CountingSort(std::size_t count, std::size_t keys, std::size_t chunks, KeysOf keys_of)
      : count_(count), keys_(keys), chunks_(chunks), keys_of_(keys_of), places_(chunks * keys) {
    each([](std::size_t, Index& place) { ++place; });
    for (std::size_t key = 0; key < keys_; ++key)
      for (std::size_t place = key; place < places_.size(); place += keys_)
        size_ += std::exchange(places_[place], size_);
  }

  Index size() const { return size_; }
  /// Calls put(i, place) for every element and key. May be called once.
  template <class Put>
  void scatter(Put&& put) {
    each([&](std::size_t i, Index& place) { put(i, place++); });
  }
  /// The end of the elements of each key. Valid after scatter().
  std::span<const Index> ends() const { return std::span(places_).last(keys_); }

 private:
  template <class F>
  void each(F&& f) {
    parallel_for_each(0, chunks_, 1, [&](std::size_t chunk) {
      Index* const place = places_.data() + chunk * keys_;
      const std::size_t end = count_ * (chunk + 1) / chunks_;
      for (std::size_t i = count_ * chunk / chunks_; i < end; ++i)
        keys_of_(i, [&](std::size_t key) { f(i, place[key]); });
    });
  }

  std::size_t count_, keys_, chunks_;
  KeysOf keys_of_;
  std::vector<Index> places_;  // of the next element of each chunk and key
  Index size_ = 0;
};

}  // namespace boxunion

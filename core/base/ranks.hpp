#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/memory.hpp"
#include "core/base/radix_sort.hpp"

namespace boxunion {

/// The ranks of some numbers: their positions among the sorted distinct ones. Reuses its memory.
class Ranks {
 public:
  /// Ranks number(0) .. number(count - 1), unsigned integers of 32 bits. count must fit 32 bits.
  template <class Number>
  void assign(std::size_t count, Number&& number) {
    sorted_.resize(count);
    scratch_.resize(count);
    ranks_.resize(count);
    for (std::size_t i = 0; i < count; ++i) sorted_[i] = std::uint64_t{number(i)} << 32 | i;
    radix_sort(std::span(sorted_), std::span(scratch_), kNumber);
    distinct_ = 0;
    for (std::size_t i = 0; i < count; ++i) {
      distinct_ += i == 0 || kNumber(sorted_[i]) != kNumber(sorted_[i - 1]);
      ranks_[static_cast<std::uint32_t>(sorted_[i])] = distinct_ - 1;
    }
  }
  void clear() { ranks_.clear(); }

  bool empty() const { return ranks_.empty(); }
  std::uint32_t operator[](std::size_t i) const { return ranks_[i]; }
  /// The number of distinct numbers.
  std::uint32_t distinct() const { return distinct_; }

 private:
  static constexpr auto kNumber = [](std::uint64_t sorted) {
    return static_cast<std::uint32_t>(sorted >> 32);
  };

  Array<std::uint64_t> sorted_, scratch_;  // a number above its index
  Array<std::uint32_t> ranks_;
  std::uint32_t distinct_ = 0;
};

}  // namespace boxunion

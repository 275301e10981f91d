#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/counting_sort.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {

/// The bits of a double as an unsigned integer that sorts as the double does. -0.0 and 0.0 give the same
/// bits. Not for NaN.
inline std::uint64_t ordered_bits(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x + 0.0);
  return bits ^ (std::uint64_t(1) << 63 | (0 - (bits >> 63)));
}

/// The inverse of ordered_bits (0.0 for -0.0).
inline double from_ordered_bits(std::uint64_t bits) {
  return std::bit_cast<double>(bits ^ (std::uint64_t(1) << 63 | ((bits >> 63) - 1)));
}

namespace detail {

/// Sorts by the highest bits in which the keys differ, then sorts every bucket by itself. The first round
/// goes through memory; later rounds work on buckets in cache. Bits that all keys of a bucket share cost
/// nothing. Several threads split buckets that are still large, so a bucket with nearly all elements does no
/// harm.
template <class T, class KeyOf>
class RadixSort {
  using Key = std::remove_cvref_t<std::invoke_result_t<KeyOf, const T&>>;

 public:
  static constexpr std::size_t kInsertion = 32;  // elements

  explicit RadixSort(KeyOf key) : key_(key) {}

  /// Sorts from[0, n). The result goes to `to` if `move` is true, otherwise it stays in place. The other
  /// array is left with unspecified contents.
  void sort(T* from, T* to, std::size_t n, bool move) const {
    if (n <= kInsertion) return insert(from, move ? to : from, n);
    if (const Key varying = varying_bits(from, n); varying != 0) return split(from, to, n, move, varying);
    if (move) std::copy(from, from + n, to);
  }

 private:
  static constexpr std::size_t kChunk = 1 << 14;  // elements per thread
  static constexpr std::size_t kMaxChunks = 64;
  static constexpr std::size_t kShare = 1 << 11;    // minimum number of elements in the buckets of a thread
  static constexpr std::size_t kInCache = 1 << 18;  // bytes

  void insert(const T* from, T* to, std::size_t n) const {
    for (std::size_t i = 0; i < n; ++i) {
      const T value = from[i];
      const Key key = key_(value);
      std::size_t j = i;
      for (; j > 0 && key < key_(to[j - 1]); --j) to[j] = to[j - 1];
      to[j] = value;
    }
  }

  Key varying_bits(const T* values, std::size_t n) const {
    const Key first = key_(values[0]);
    return parallel_reduce(
        0, n, kChunk, Key(0),
        [&](std::size_t begin, std::size_t end, Key varying) {
          for (std::size_t i = begin; i < end; ++i) varying |= key_(values[i]) ^ first;
          return varying;
        },
        std::bit_or<>());
  }

  void split(T* from, T* to, std::size_t n, bool move, Key varying) const {
    // Choose the number of buckets so that an average bucket is left to insertion sort.
    const int width = bit_width(varying);
    const int most_bits = n * sizeof(T) <= kInCache ? 11 : 8;  // so many write positions stay in cache
    const int digit_bits = std::min({width, most_bits, bit_width(n) - 3});
    const int shift = width - digit_bits;
    const std::size_t buckets = std::size_t(1) << digit_bits;
    const auto digit = [&](const T& value) {
      return static_cast<std::size_t>(key_(value) >> shift) & (buckets - 1);
    };

    const std::size_t chunks = std::clamp(n / kChunk, std::size_t(1), kMaxChunks);
    const auto keys_of = [&](std::size_t i, auto&& f) { f(digit(from[i])); };
    CountingSort<std::size_t, decltype(keys_of)> sorting(n, buckets, chunks, keys_of);
    sorting.scatter([&](std::size_t i, std::size_t place) { to[place] = from[i]; });

    const std::span<const std::size_t> ends = sorting.ends();
    const std::size_t grain = std::max<std::size_t>(1, buckets * kShare / n);
    parallel_ranges(0, buckets, grain, [&](std::size_t first, std::size_t last) {
      std::size_t begin = first == 0 ? 0 : ends[first - 1];
      for (std::size_t bucket = first; bucket < last; begin = ends[bucket++])
        sort(to + begin, from + begin, ends[bucket] - begin, !move);
    });
  }

  template <class Integer>
  static int bit_width(Integer x) {
    if constexpr (sizeof(x) > sizeof(std::uint64_t))
      if (x >> 64 != 0) return 64 + bit_width(static_cast<std::uint64_t>(x >> 64));
    return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(x)));
  }

  KeyOf key_;
};

}  // namespace detail

/// Sorts values in ascending order of key(value), an unsigned integer of 32, 64 or 128 bits. Parallel and
/// stable. `scratch` is as long as `values` (it may be empty for up to 32 of them), and its contents are
/// unspecified afterwards.
template <class T, class KeyOf = std::identity>
void radix_sort(std::span<T> values, std::span<T> scratch, KeyOf key = {}) {
  detail::RadixSort<T, KeyOf>(key).sort(values.data(), scratch.data(), values.size(), false);
}

/// The same with its own scratch.
template <class T, class KeyOf = std::identity>
void radix_sort(std::span<T> values, KeyOf key = {}) {
  using Sort = detail::RadixSort<T, KeyOf>;
  auto scratch = make_array<T>(values.size() <= Sort::kInsertion ? 0 : values.size(), "sorting");
  radix_sort(values, std::span(scratch), key);
}

}  // namespace boxunion

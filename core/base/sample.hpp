#pragma once

#include <cstddef>
#include <cstdint>

namespace boxunion {

/// A number that looks random and depends on i alone (the finalizer of SplitMix64, Steele, Lea and Flood
/// 2014).
constexpr std::uint64_t hash_of(std::uint64_t i) {
  i += 0x9e3779b97f4a7c15u;
  i = (i ^ i >> 30) * 0xbf58476d1ce4e5b9u;
  i = (i ^ i >> 27) * 0x94d049bb133111ebu;
  return i ^ i >> 31;
}

/// A sample of 0, 1, 2, ...: one position out of every `step`, chosen by a hash. It is the same every time,
/// and no period of the input coincides with it.
class Sample {
 public:
  /// For `size` elements, at most `most` positions.
  Sample(std::uint64_t size, std::uint64_t most) : size_(size), step_(size / most + (size % most != 0)) {}

  /// Calls f(position) for the positions from begin to end - 1 that are in the sample, in order.
  template <class F>
  void each(std::uint64_t begin, std::uint64_t end, F&& f) const {
    if (begin >= end) return;
    for (std::uint64_t stratum = begin / step_; stratum * step_ < end; ++stratum) {
      const std::uint64_t position = stratum * step_ + hash_of(stratum) % step_;
      if (begin <= position && position < end) f(position);
    }
  }
  template <class F>
  void each(F&& f) const {
    each(0, size_, f);
  }

 private:
  std::uint64_t size_, step_;
};

}  // namespace boxunion

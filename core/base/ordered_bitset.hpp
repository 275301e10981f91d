#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace boxunion {

/// An ordered set of integers 0 .. size - 1: a tree of bitmaps with 64 children per node. An operation takes
/// a handful of instructions per level (four levels for 16 M integers).
class OrderedBitset {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  OrderedBitset() = default;
  explicit OrderedBitset(std::uint32_t size) {
    std::size_t words = size;
    do {
      words = (words + 63) / 64;
      levels_.emplace_back(words, 0);
    } while (words > 1);
  }

  bool contains(std::uint32_t i) const { return levels_[0][i >> 6] >> (i & 63) & 1; }

  void insert(std::uint32_t i) {
    for (auto& level : levels_) {
      std::uint64_t& word = level[i >> 6];
      const bool was_empty = word == 0;
      word |= std::uint64_t{1} << (i & 63);
      if (!was_empty) return;
      i >>= 6;
    }
  }

  void erase(std::uint32_t i) {
    for (auto& level : levels_) {
      std::uint64_t& word = level[i >> 6];
      word &= ~(std::uint64_t{1} << (i & 63));
      if (word != 0) return;
      i >>= 6;
    }
  }

  /// The smallest element above i, or kNone.
  std::uint32_t above(std::uint32_t i) const {
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      const std::uint64_t word = levels_[l][i >> 6] & (~std::uint64_t{1} << (i & 63));
      i >>= 6;
      if (word == 0) continue;
      i = i << 6 | std::uint32_t(std::countr_zero(word));
      while (l-- > 0) i = i << 6 | std::uint32_t(std::countr_zero(levels_[l][i]));
      return i;
    }
    return kNone;
  }

  /// The largest element below i, or kNone.
  std::uint32_t below(std::uint32_t i) const {
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      const std::uint64_t word = levels_[l][i >> 6] & ((std::uint64_t{1} << (i & 63)) - 1);
      i >>= 6;
      if (word == 0) continue;
      i = i << 6 | (63u - std::uint32_t(std::countl_zero(word)));
      while (l-- > 0) i = i << 6 | (63u - std::uint32_t(std::countl_zero(levels_[l][i])));
      return i;
    }
    return kNone;
  }

 private:
  std::vector<std::vector<std::uint64_t>> levels_;  // leaves first
};

}  // namespace boxunion

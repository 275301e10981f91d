#pragma once

#include <atomic>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {

/// A partition of 0 .. size - 1 whose sets can only be joined. The lowest element represents its set, so the
/// result does not depend on the order of calls. (Anderson and Woll 1991: links towards lower elements by
/// compare and swap, with path halving.)
class DisjointSets {
 public:
  /// `what` names the purpose of the memory, for Error(resources).
  DisjointSets(std::uint32_t size, const std::string& what) {
    with_memory(what, size * sizeof(std::uint32_t), [&] { parents_.resize(size); });
    parallel_ranges(0, size, std::size_t{1} << 16, [&](std::size_t begin, std::size_t end) {
      std::iota(parents_.begin() + std::ptrdiff_t(begin), parents_.begin() + std::ptrdiff_t(end),
                std::uint32_t(begin));
    });
  }

  /// The lowest element of an element's set. Thread-safe.
  std::uint32_t find(std::uint32_t i) {
    for (;;) {
      const std::uint32_t parent = at(i).load(std::memory_order_relaxed);
      if (parent == i) return i;
      const std::uint32_t grandparent = at(parent).load(std::memory_order_relaxed);
      if (grandparent == parent) return parent;
      // If the compare and swap fails, i is no longer a root, and whatever another thread stored is an
      // ancestor too.
      at(i).store(grandparent, std::memory_order_relaxed);
      i = grandparent;
    }
  }

  /// True if an element is the lowest of its set. Not while sets are joined.
  bool is_lowest(std::uint32_t i) const { return parents_[i] == i; }

  /// Joins the sets of two elements. Thread-safe.
  void join(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t root = a;
      if (at(a).compare_exchange_strong(root, b, std::memory_order_relaxed)) return;
    }
  }

  /// The parent of each element: the element itself if it represents its set, otherwise a lower element of
  /// the set. Leaves this object empty.
  Array<std::uint32_t> take_parents() { return std::move(parents_); }

 private:
  std::atomic_ref<std::uint32_t> at(std::uint32_t i) { return std::atomic_ref(parents_[i]); }

  Array<std::uint32_t> parents_;
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.hpp"

namespace boxunion {

/// Throws an error that says what was to be allocated, and how much.
[[noreturn]] inline void throw_out_of_memory(const std::string& what, std::size_t bytes) {
  throw Error(ErrorKind::resources,
              "out of memory: " + what + " needs " + std::to_string(bytes) + " bytes in one piece");
}

/// Returns allocate(), a call that allocates about `bytes` for `what` at once. If memory does not suffice,
/// throws Error(resources) with a message that says so.
template <class F>
auto with_memory(const std::string& what, std::size_t bytes, F&& allocate) {
  try {
    return allocate();
  } catch (const std::bad_alloc&) {
    throw_out_of_memory(what, bytes);
  } catch (const std::length_error&) {
    throw_out_of_memory(what, bytes);
  }
}

/// Bytes of a huge page of the system.
inline constexpr std::size_t kHugePage = std::size_t{1} << 21;

namespace detail {
/// Allocates and frees memory of large arrays; see ArrayAllocator. Throws std::bad_alloc.
void* allocate_array(std::size_t bytes);
void deallocate_array(void* memory, std::size_t bytes);
}  // namespace detail

/// An allocator for arrays of numbers. It does not initialize new elements. Getting small pages from the
/// system takes longer than filling them. So arrays of medium size come from oneTBB's allocator, which keeps
/// freed memory. Arrays from half a huge page on consist of whole huge pages, if the system has them.
template <class T>
class ArrayAllocator {
 public:
  using value_type = T;

  ArrayAllocator() = default;
  template <class U>
  ArrayAllocator(const ArrayAllocator<U>&) {}

  T* allocate(std::size_t n) {
    if (n > std::size_t(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(detail::allocate_array(n * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t n) { detail::deallocate_array(memory, n * sizeof(T)); }

  template <class U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
  friend bool operator==(const ArrayAllocator&, const ArrayAllocator&) { return true; }
};

/// A vector of numbers that several threads fill. Growing it does not first fill it with zeros on one thread.
template <class T>
using Array = std::vector<T, ArrayAllocator<T>>;

/// An array for `what`. Throws as with_memory does.
template <class T>
Array<T> make_array(std::size_t size, const std::string& what) {
  return with_memory(what, size * sizeof(T), [&] { return Array<T>(size); });
}

/// Append-only list of unknown length, in blocks that double up to a huge page. Unlike a growing array, it
/// never copies elements, and its memory is reused by the next list.
template <class T>
class BlockList {
 public:
  /// Appends elements, at least one and at most `most`, for the caller to fill.
  std::span<T> extend(std::size_t most) {
    if (blocks_.empty() || blocks_.back().size() == blocks_.back().capacity()) {
      const std::size_t last = blocks_.empty() ? 0 : blocks_.back().capacity();
      blocks_.emplace_back().reserve(std::clamp(2 * last, kFewest, kMost));
    }
    Array<T>& block = blocks_.back();
    const std::size_t size = block.size();
    const std::size_t count = std::min(most, block.capacity() - size);
    block.resize(size + count);
    return {block.data() + size, count};
  }
  std::span<const Array<T>> blocks() const { return blocks_; }

 private:
  static constexpr std::size_t kFewest = 1024;
  static constexpr std::size_t kMost = kHugePage / sizeof(T);

  std::vector<Array<T>> blocks_;
};

}  // namespace boxunion

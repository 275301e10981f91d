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

/// Says what was to be allocated, and how much.
[[noreturn]] inline void throw_out_of_memory(const std::string& what, std::size_t bytes) {
  throw Error(ErrorKind::resources,
              "out of memory: " + what + " needs " + std::to_string(bytes) + " bytes in one piece");
}

/// Returns allocate(), a call that allocates about `bytes` for `what` at once; where memory does not suffice
/// it throws Error(resources) that says so.
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
/// Memory for large arrays and back; see ArrayAllocator. Throws std::bad_alloc.
void* allocate_array(std::size_t bytes);
void deallocate_array(void* memory, std::size_t bytes);
}  // namespace detail

/// An allocator for arrays of numbers. New elements keep whatever their memory holds. Memory in small pages
/// takes longer to get from the system than to fill, so arrays of middle size come from oneTBB's allocator,
/// which keeps what was freed, and those from half a huge page on are whole huge pages, where the system has
/// them.
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

/// A vector of numbers that several threads fill: growing it does not fill it with zeros first, on one
/// thread.
template <class T>
using Array = std::vector<T, ArrayAllocator<T>>;

/// An array for `what`; throws as with_memory does.
template <class T>
Array<T> make_array(std::size_t size, const std::string& what) {
  return with_memory(what, size * sizeof(T), [&] { return Array<T>(size); });
}

/// Numbers of which nobody knows how many will come: blocks that double up to a huge page. Unlike an array
/// that grows it never copies them, and what it takes from the system comes back to the next list.
template <class T>
class BlockList {
 public:
  /// New elements at the end, at least one and at most `most`, for the caller to fill.
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

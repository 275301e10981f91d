#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

namespace detail {
/// Allocates and frees memory of large arrays; see ArrayAllocator. Throws std::bad_alloc.
BOXUNION_API void* allocate_array(std::size_t bytes);
BOXUNION_API void deallocate_array(void* memory, std::size_t bytes);
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

}  // namespace boxunion

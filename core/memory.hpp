#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"

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

/// An allocator for large arrays of numbers: new elements keep whatever their memory holds, and where the
/// system has huge pages it is asked for them, for memory in small ones takes longer to get than to fill.
/// From half a huge page on, arrays take whole ones.
template <class T>
class LargeAllocator {
 public:
  using value_type = T;

  LargeAllocator() = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&) {}

  T* allocate(std::size_t n) {
    if (n > std::size_t(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    if (!is_large(n)) return static_cast<T*>(::operator new(n * sizeof(T)));
    constexpr std::size_t kPage = std::size_t(kHugePage);
    const std::size_t bytes = (n * sizeof(T) + kPage - 1) / kPage * kPage;
    void* const memory = ::operator new(bytes, kHugePage);
#ifdef MADV_HUGEPAGE
    ::madvise(memory, bytes, MADV_HUGEPAGE);  // no harm if it fails
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) {
    if (is_large(n))  // no conditional expression: of this one clang++ 14 calls both sides
      ::operator delete(memory, kHugePage);
    else
      ::operator delete(memory);
  }

  template <class U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
  friend bool operator==(const LargeAllocator&, const LargeAllocator&) {
    return true;
  }

 private:
  static constexpr std::align_val_t kHugePage{std::size_t{1} << 21};
  static bool is_large(std::size_t n) {
    return n * sizeof(T) >= std::size_t(kHugePage) / 2;
  }
};

/// A vector of numbers that several threads fill: growing it does not fill it with zeros first, on one
/// thread.
template <class T>
using Array = std::vector<T, LargeAllocator<T>>;

/// An array for `what`; throws as with_memory does.
template <class T>
Array<T> make_array(std::size_t size, const std::string& what) {
  return with_memory(what, size * sizeof(T), [&] { return Array<T>(size); });
}

}  // namespace boxunion

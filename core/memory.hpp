#pragma once

#include <sys/mman.h>
#include <tbb/scalable_allocator.h>

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

// Sanitizers know nothing of oneTBB's allocator, so built with one everything comes from the language's.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define BOXUNION_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define BOXUNION_SANITIZED
#endif
#endif

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
    std::size_t bytes = n * sizeof(T);
    if (bytes < kHugePage / 2) return static_cast<T*>(allocate_some(bytes));
    bytes = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    void* const memory = ::operator new(bytes, std::align_val_t(kHugePage));
#ifdef MADV_HUGEPAGE
    ::madvise(memory, bytes, MADV_HUGEPAGE);  // no harm if it fails
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) {
    if (n * sizeof(T) < kHugePage / 2)
      deallocate_some(memory);
    else
      ::operator delete(memory, std::align_val_t(kHugePage));
  }

  template <class U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
  friend bool operator==(const ArrayAllocator&, const ArrayAllocator&) {
    return true;
  }

 private:
  static constexpr std::size_t kHugePage = std::size_t{1} << 21;

#ifdef BOXUNION_SANITIZED
  static void* allocate_some(std::size_t bytes) {
    return ::operator new(bytes);
  }
  static void deallocate_some(void* memory) {
    ::operator delete(memory);
  }
#else
  static void* allocate_some(std::size_t bytes) {
    void* const memory = scalable_malloc(bytes);
    if (!memory) throw std::bad_alloc();
    return memory;
  }
  static void deallocate_some(void* memory) {
    scalable_free(memory);
  }
#endif
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

}  // namespace boxunion

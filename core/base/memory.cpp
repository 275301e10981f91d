#include "core/base/memory.hpp"

#include <sys/mman.h>
#include <tbb/scalable_allocator.h>

#include <cstddef>
#include <new>

namespace boxunion::detail {
namespace {

constexpr std::size_t kLeastPages = kHugePage / 2;  // an array of so many bytes takes whole huge pages
constexpr std::size_t kMostKept = 16 * kHugePage;   // larger arrays go back to the system when they are freed

constexpr std::size_t in_pages(std::size_t bytes) {
  return (bytes + kHugePage - 1) / kHugePage * kHugePage;
}

// oneTBB's allocator keeps freed memory for the next array, because most of the time for a new array goes
// into getting its pages from the system. Sanitizers do not know this allocator.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define BOXUNION_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define BOXUNION_SANITIZED
#endif
#endif
#ifdef BOXUNION_SANITIZED
bool is_kept(std::size_t) {
  return false;
}
#else
bool is_kept(std::size_t bytes) {
  return bytes <= kMostKept;
}
#endif

std::size_t alignment_of(std::size_t bytes) {
  return bytes < kLeastPages ? alignof(std::max_align_t) : kHugePage;
}

}  // namespace

void* allocate_array(std::size_t bytes) {
  const std::size_t alignment = alignment_of(bytes);
  if (alignment == kHugePage) bytes = in_pages(bytes);
  void* const memory = is_kept(bytes) ? scalable_aligned_malloc(bytes, alignment)
                                      : ::operator new(bytes, std::align_val_t(alignment));
  if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (alignment == kHugePage) ::madvise(memory, bytes, MADV_HUGEPAGE);  // harmless if it fails
#endif
  return memory;
}

void deallocate_array(void* memory, std::size_t bytes) {
  const std::size_t alignment = alignment_of(bytes);
  if (alignment == kHugePage) bytes = in_pages(bytes);
  // no conditional expression: with operator delete in one, clang++ 14 calls both sides
  if (is_kept(bytes))
    scalable_aligned_free(memory);
  else
    ::operator delete(memory, std::align_val_t(alignment));
}

}  // namespace boxunion::detail

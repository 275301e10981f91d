#include "core/memory.hpp"

#include <sys/mman.h>
#include <tbb/scalable_allocator.h>

namespace boxunion::detail {
namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;

bool takes_whole_pages(std::size_t bytes) {
  return bytes >= kHugePage / 2;
}

// Sanitizers know nothing of oneTBB's allocator.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define BOXUNION_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define BOXUNION_SANITIZED
#endif
#endif
#ifdef BOXUNION_SANITIZED
void* allocate_some(std::size_t bytes) {
  return ::operator new(bytes);
}
void deallocate_some(void* memory) {
  ::operator delete(memory);
}
#else
void* allocate_some(std::size_t bytes) {
  void* const memory = scalable_malloc(bytes);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void deallocate_some(void* memory) {
  scalable_free(memory);
}
#endif

}  // namespace

void* allocate_array(std::size_t bytes) {
  if (!takes_whole_pages(bytes)) return allocate_some(bytes);
  bytes = (bytes + kHugePage - 1) / kHugePage * kHugePage;
  void* const memory = ::operator new(bytes, std::align_val_t(kHugePage));
#ifdef MADV_HUGEPAGE
  ::madvise(memory, bytes, MADV_HUGEPAGE);  // no harm if it fails
#endif
  return memory;
}

void deallocate_array(void* memory, std::size_t bytes) {
  // no conditional expression: of one with operator delete clang++ 14 calls both sides
  if (takes_whole_pages(bytes))
    ::operator delete(memory, std::align_val_t(kHugePage));
  else
    deallocate_some(memory);
}

}  // namespace boxunion::detail

#pragma once

namespace boxunion {

extern "C" void __asan_init() __attribute__((weak));
extern "C" void __tsan_init() __attribute__((weak));

/// True if the library and the command were built with sanitizers that reserve more memory than any limit.
/// The tests themselves may be the same objects either way, so this is known only at run time.
inline bool sanitized() {
  return __asan_init != nullptr || __tsan_init != nullptr;
}

}  // namespace boxunion

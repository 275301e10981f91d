#pragma once

#include <cstddef>
#include <new>
#include <stdexcept>
#include <string>

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

}  // namespace boxunion

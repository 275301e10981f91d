#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "boxunion/array.hpp"
#include "boxunion/error.hpp"

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

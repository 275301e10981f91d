#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/union.hpp"

// Shared by the fuzz targets. A target accepts any bytes, and ends the process if a law is broken.

/// The entry point of a target for libFuzzer. driver.cpp calls it in other builds.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count);

namespace boxunion::fuzz {

/// Unless a law holds, ends the process, so that the input is kept.
inline void expect(bool law, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (law) return;
  std::fprintf(stderr, "%s:%d: broken law\n", file, line);
  std::abort();
}

inline Options native() {
  return {.device = "native", .threads = 1};
}

/// Takes numbers from the bytes of an input. After the end, they are zeros.
class Bytes {
 public:
  Bytes(const std::uint8_t* bytes, std::size_t count) : rest_(bytes, count) {}

  /// A number less than `limit`, which is at most 256.
  int below(int limit) {
    if (rest_.empty()) return 0;
    const int value = rest_.front() % limit;
    rest_ = rest_.subspan(1);
    return value;
  }
  template <class T, std::size_t N>
  T one_of(const std::array<T, N>& values) {
    return values[std::size_t(below(N))];
  }

 private:
  std::span<const std::uint8_t> rest_;
};

/// Fewer than `limit` boxes with coordinates 0 .. range, so that all degenerate cases occur.
inline std::vector<IntegerBox> take_boxes(Bytes& bytes, int limit, int range) {
  std::vector<IntegerBox> boxes(std::size_t(bytes.below(limit)));
  for (IntegerBox& box : boxes)
    for (std::size_t a = 0; a < 3; ++a) {
      const int p = bytes.below(range + 1), q = bytes.below(range + 1);
      box[a] = std::min(p, q);
      box[a + 3] = std::max(p, q);
    }
  return boxes;
}

/// The same, as integers or as doubles of some scale. One of the doubles may be far from the others.
inline BoxSet take_box_set(Bytes& bytes, int limit, int range) {
  const double scale = bytes.one_of(std::array{0.0, 1.0, 0.1, 0x1p-1070, 0x1p-40, 1e300});
  const bool has_far_one = bytes.below(2) == 1;
  const std::vector<IntegerBox> integers = take_boxes(bytes, limit, range);
  if (scale == 0) return integers;
  std::vector<Box> boxes(integers.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t c = 0; c < 6; ++c)
      boxes[i][c] = has_far_one && integers[i][c] == 1 ? scale * 0x1p-60 : scale * integers[i][c];
  return boxes;
}

}  // namespace boxunion::fuzz

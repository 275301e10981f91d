#include "boxunion/rectangle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "boxunion/box.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {

void validate(const RectangleSet& set) {
  // NaN fails every comparison; x - x is 0 for finite x only
  const auto is_valid = [](const auto& r) {
    return r[0] <= r[2] && r[1] <= r[3] && r[0] - r[0] == 0 && r[1] - r[1] == 0 && r[2] - r[2] == 0 &&
           r[3] - r[3] == 0;
  };
  set.visit([&](const auto& rectangles) {
    const std::size_t first = parallel_reduce(
        0, rectangles.size(), 1 << 16, rectangles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t before) {
          for (std::size_t i = begin; i < std::min(end, before); ++i)
            if (!is_valid(rectangles[i])) return i;
          return before;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (first == rectangles.size()) return;
    const auto& r = rectangles[first];
    validate(Box{double(r[0]), double(r[1]), 0, double(r[2]), double(r[3]), 0},
             fmt::format("rectangle {}", first + 1));
  });
}

}  // namespace boxunion

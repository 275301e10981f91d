#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/parallel.hpp"

namespace boxunion {

/// Writes rows 0 .. count - 1 to a file or a part of one. append(row, text) appends a row to a buffer.
/// Parallel.
template <class Sink, class F>
void write_rows(Sink& sink, std::size_t count, F append) {
  constexpr std::size_t kChunks = 64, kRows = 1 << 12;
  std::vector<fmt::memory_buffer> texts(kChunks);
  for (std::size_t first = 0; first < count; first += kChunks * kRows) {
    const std::size_t rows = std::min(kChunks * kRows, count - first);
    const std::size_t chunks = (rows + kRows - 1) / kRows;
    parallel_for_each(0, chunks, 1, [&](std::size_t i) {
      texts[i].clear();
      const std::size_t last = first + std::min((i + 1) * kRows, rows);
      for (std::size_t row = first + i * kRows; row < last; ++row) append(row, texts[i]);
    });
    for (std::size_t i = 0; i < chunks; ++i) sink.write({texts[i].data(), texts[i].size()});
  }
}

}  // namespace boxunion

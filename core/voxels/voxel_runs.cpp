#include "core/voxels/voxel_runs.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>

#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

/// A word whose bit i is set if byte i is not 0.
std::uint64_t bits_of_64(const std::uint8_t* bytes) {
  std::uint64_t bits = 0;
#ifdef __SSE2__
  for (unsigned i = 0; i < 64; i += 16) {
    const __m128i sixteen = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes + i));
    const auto zeros = unsigned(_mm_movemask_epi8(_mm_cmpeq_epi8(sixteen, _mm_setzero_si128())));
    bits |= std::uint64_t(zeros ^ 0xffff) << i;
  }
#else
  static_assert(std::endian::native == std::endian::little, "byte i of a word is voxel i");
  constexpr std::uint64_t kLow7 = 0x7f7f7f7f7f7f7f7f, kGather = 0x0102040810204080;
  for (unsigned i = 0; i < 64; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, bytes + i, 8);
    bits |= (((((eight & kLow7) + kLow7) | eight) >> 7 & (~kLow7 >> 7)) * kGather >> 56) << i;
  }
#endif
  return bits;
}

/// Calls f(x, changes) for every 64 voxels from x on that have changes. Bit i of `changes` is set if voxels x
/// + i - 1 and x + i differ; voxels beyond the ends of the row are outside. x may be `width`.
template <class F>
void for_each_change(const std::uint8_t* row, std::size_t width, F&& f) {
  std::uint64_t before = 0;
  for (std::size_t x = 0; x < width; x += 64) {
    std::uint64_t bits;
    if (x + 64 <= width) {
      bits = bits_of_64(row + x);
    } else {
      std::array<std::uint8_t, 64> rest{};
      std::copy(row + x, row + width, rest.begin());
      bits = bits_of_64(rest.data());
    }
    if (const std::uint64_t changes = bits ^ (bits << 1 | before)) f(x, changes);
    before = bits >> 63;
  }
  if (before) f(width, std::uint64_t{1});
}

}  // namespace

VoxelRuns::VoxelRuns(std::span<const std::uint8_t> inside, std::size_t width) {
  const std::size_t rows = width == 0 ? 0 : inside.size() / width;
  const std::size_t grain =
      std::max<std::size_t>((std::size_t{1} << 18) / std::max<std::size_t>(width, 1), 1);
  const auto row = [&](std::size_t r) { return inside.data() + r * width; };
  with_memory("the rows of the volume", (rows + 1) * sizeof(std::size_t), [&] { starts_.resize(rows + 1); });
  starts_[0] = 0;
  parallel_for_each(0, rows, grain, [&](std::size_t r) {
    std::size_t changes_of_row = 0;
    for_each_change(row(r), width, [&](std::size_t, std::uint64_t changes) {
      changes_of_row += std::size_t(std::popcount(changes));
    });
    starts_[r + 1] = changes_of_row / 2;
  });
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());

  with_memory("the runs of the volume", starts_[rows] * sizeof(Run), [&] { runs_.resize(starts_[rows]); });
  parallel_for_each(0, rows, grain, [&](std::size_t r) {
    Run* run = runs_.data() + starts_[r];
    bool is_open = false;
    for_each_change(row(r), width, [&](std::size_t x, std::uint64_t changes) {
      for (; changes; changes &= changes - 1) {
        const auto at = std::uint32_t(x + std::size_t(std::countr_zero(changes)));
        if (is_open)
          run++->end = at;
        else
          run->begin = at;
        is_open = !is_open;
      }
    });
  });
}

}  // namespace boxunion

#include "core/plane/contour_cell.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"

namespace boxunion {
namespace {

bool touches(const OrdinalRectangle& r, const OrdinalRectangle& cell) {
  return r.lo[0] < cell.hi[0] && r.hi[0] >= cell.lo[0] && r.lo[1] < cell.hi[1] && r.hi[1] >= cell.lo[1];
}

bool covers(const OrdinalRectangle& r, const OrdinalRectangle& cell) {
  return r.lo[0] < cell.lo[0] && r.hi[0] >= cell.hi[0] && r.lo[1] < cell.lo[1] && r.hi[1] >= cell.hi[1];
}

}  // namespace

template <class Bit>
void ContourCell::Places::set_ranges(std::span<const OrdinalRectangle> rectangles, unsigned axis, Bit&& bit) {
  make_ranges(rectangles.size());
  for (std::size_t i = 0; i < rectangles.size(); ++i)
    ranges_[i] = {static_cast<std::uint16_t>(bit(rectangles[i].lo[axis])),
                  static_cast<std::uint16_t>(bit(rectangles[i].hi[axis]))};
}

/// Ranks by comparing all ends with all that the cell owns, many at a time and without a branch. Equal ends
/// share a bit; the other bits remain unused. False if there are too many ends.
template <class Lane>
bool ContourCell::Places::find_by_counting(std::span<const OrdinalRectangle> rectangles, unsigned axis) {
  using Lanes [[gnu::vector_size(16)]] = Lane;
  constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(Lane);
  constexpr auto kLeast = std::numeric_limits<Lane>::min();
  alignas(Lanes) std::array<Lane, 2 * kCounted> offsets;
  Lanes owned[kBits];
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    if (count > kBits - 3) return false;
    for (const unsigned end : {0u, 1u}) {
      const std::uint32_t place = offset((end == 0 ? rectangles[i].lo : rectangles[i].hi)[axis]);
      owned[count] = Lanes{} + (offsets[2 * i + end] = static_cast<Lane>(place + std::uint32_t(kLeast)));
      count += place - 1 < extent_;
    }
  }
  count_ = count;
  make_ranges(rectangles.size());
  make_ordinals();
  for (std::size_t begin = 0; begin < 2 * rectangles.size(); begin += kLanes) {
    Lanes ends;
    std::memcpy(&ends, &offsets[begin], sizeof ends);
    Lanes bits = -(ends > Lanes{} + kLeast);
#pragma GCC unroll 8
    for (std::uint32_t i = 0; i < count; ++i) bits -= ends > owned[i];
    for (std::size_t i = 0; i < kLanes; i += 2)
      ranges_[(begin + i) / 2] = {static_cast<std::uint16_t>(bits[i]),
                                  static_cast<std::uint16_t>(bits[i + 1])};
  }
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    ordinals_[ranges_[i].begin] = rectangles[i].lo[axis];
    ordinals_[ranges_[i].end] = rectangles[i].hi[axis];
  }
  return true;
}

void ContourCell::Places::find_by_marks(std::span<const OrdinalRectangle> rectangles, unsigned axis) {
  if (marks_.empty()) {
    marks_.resize(kMarked / kBits + 1);
    bits_.resize(kMarked + 2);
  }
  const auto mark = [&](std::uint32_t place) { marks_[place / kBits] |= std::uint64_t{1} << place % kBits; };
  for (const OrdinalRectangle& r : rectangles) {
    mark(offset(r.lo[axis]));
    mark(offset(r.hi[axis]));
  }
  marks_[0] &= ~std::uint64_t{1};
  marks_[(extent_ + 1) / kBits] &= ~(std::uint64_t{1} << (extent_ + 1) % kBits);
  for (std::uint32_t w = 0; w <= extent_ / kBits; ++w)
    for (std::uint64_t word = std::exchange(marks_[w], 0); word != 0; word &= word - 1) {
      const std::uint32_t place = w * kBits + static_cast<std::uint32_t>(std::countr_zero(word));
      bits_[place] = static_cast<std::uint8_t>(ordinals_.size());
      ordinals_.push_back(lo_ - 1 + place);
    }
  bits_[0] = 0;
  bits_[extent_ + 1] = static_cast<std::uint8_t>(ordinals_.size());
}

void ContourCell::Places::find_by_sorting(std::span<const OrdinalRectangle> rectangles, unsigned axis) {
  for (const OrdinalRectangle& r : rectangles)
    for (const std::uint32_t ordinal : {r.lo[axis], r.hi[axis]})
      if (ordinal - lo_ < extent_) ordinals_.push_back(ordinal);
  std::sort(ordinals_.begin() + 1, ordinals_.end());
  ordinals_.erase(std::unique(ordinals_.begin() + 1, ordinals_.end()), ordinals_.end());
}

bool ContourCell::Places::assign(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
                                 unsigned axis) {
  lo_ = cell.lo[axis];
  extent_ = cell.hi[axis] - lo_;
  if (is_direct()) {
    count_ = extent_;
    make_ordinals();
    std::iota(ordinals_.begin(), ordinals_.begin() + kBits, lo_ - 1);
    set_ranges(rectangles, axis, [this](std::uint32_t ordinal) { return offset(ordinal); });
    return true;
  }
  if (rectangles.size() <= kCounted && (extent_ < 0xffff ? find_by_counting<std::int16_t>(rectangles, axis)
                                                         : find_by_counting<std::int32_t>(rectangles, axis)))
    return true;
  ordinals_.resize(1);
  const bool by_marks = extent_ <= kMarked;
  by_marks ? find_by_marks(rectangles, axis) : find_by_sorting(rectangles, axis);
  count_ = static_cast<std::uint32_t>(ordinals_.size() - 1);
  if (count_ >= kBits) return false;
  if (by_marks)
    set_ranges(rectangles, axis, [this](std::uint32_t ordinal) { return bits_[offset(ordinal)]; });
  else
    set_ranges(rectangles, axis, [this](std::uint32_t ordinal) {
      const auto places =
          std::upper_bound(ordinals_.begin() + 1, ordinals_.end(), ordinal) - ordinals_.begin();
      return places - (ordinal < lo_ + extent_);
    });
  return true;
}

bool ContourCell::find(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
                       Array<ContourVertex>& out) {
  constexpr std::size_t kMany = 512;
  if (rectangles.size() > kMany) {  // some rectangles may already be too many for the cell
    std::vector<OrdinalRectangle> sample;
    Sample(rectangles.size(), kMany / 2).each([&](std::size_t i) { sample.push_back(rectangles[i]); });
    for (const unsigned axis : {0u, 1u})
      if (!places_[axis].assign(cell, sample, axis)) return halve(cell, rectangles, axis, out);
  }
  for (const unsigned axis : {0u, 1u}) {
    if (!places_[axis].assign(cell, rectangles, axis)) return halve(cell, rectangles, axis, out);
    if (places_[axis].count() == 0) return true;
  }
  fill();
  emit(out);
  return true;
}

/// The lower half comes first, so that x ascends on every row. If one half lies above the other, the rows
/// ascend too.
bool ContourCell::halve(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
                        unsigned axis, Array<ContourVertex>& out) {
  Interruptible::check();
  const std::uint32_t middle = places_[axis].middle();
  std::vector<OrdinalRectangle> touching;
  bool rows_ascend = axis == 1;
  for (const bool upper : {false, true}) {
    OrdinalRectangle half = cell;
    (upper ? half.lo : half.hi)[axis] = middle;
    if (std::ranges::any_of(rectangles, [&](const OrdinalRectangle& r) { return covers(r, half); })) continue;
    touching.clear();
    for (const OrdinalRectangle& r : rectangles)
      if (touches(r, half)) touching.push_back(r);
    rows_ascend &= find(half, touching, out);
  }
  return rows_ascend;
}

void ContourCell::fill() {
  const std::uint32_t count = places_[1].count();
  std::fill_n(rows_.begin(), count + 1, 0);
  std::uint64_t ends = 0;  // bit 64 lies beyond what the cell owns; it is harmless as bit 0
  const std::span<const Places::Range> columns = places_[0].ranges(), rows = places_[1].ranges();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto [begin, end] = rows[i];
    const std::uint64_t bits = ~std::uint64_t{0} >> (kBits - columns[i].end) & ~std::uint64_t{0}
                                                                                   << columns[i].begin;
    for (std::uint32_t row = begin; row < end; ++row) rows_[row] |= bits;
    ends |= std::uint64_t{1} << begin % kBits | std::uint64_t{1} << end % kBits;
  }
  occurring_ = ends & ~std::uint64_t{0} >> (kBits - 1 - count) & ~std::uint64_t{1};
}

void ContourCell::emit(Array<ContourVertex>& out) const {
  const std::uint32_t *const xs = places_[0].ordinals(), *const ys = places_[1].ordinals();
  const std::size_t before = out.size();
  out.resize(before + places_[0].count() * places_[1].count());
  ContourVertex* vertex = out.data() + before;
  const std::uint64_t owned = ~std::uint64_t{0} >> (kBits - places_[0].count());
  for (std::uint64_t rest = occurring_; rest != 0; rest &= rest - 1) {
    const auto row = static_cast<std::uint32_t>(std::countr_zero(rest));
    const std::uint64_t below = rows_[row - 1], above = rows_[row], differ = below ^ above;
    const std::uint64_t along_x = (below ^ below >> 1) | (above ^ above >> 1), along_y = differ | differ >> 1;
    const std::uint32_t y = ys[row];
    for (std::uint64_t bits = along_x & along_y & owned; bits != 0; bits &= bits - 1) {
      const auto place = static_cast<std::uint32_t>(std::countr_zero(bits));
      *vertex++ = {xs[place + 1], y,
                   static_cast<std::uint32_t>((below >> place & 3) | (above >> place & 3) << 2)};
    }
  }
  out.resize(static_cast<std::size_t>(vertex - out.data()));
}

}  // namespace boxunion

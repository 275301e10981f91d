#include "core/contour_cell.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/parallel.hpp"

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
  ranges_.resize(rectangles.size());
  for (std::size_t i = 0; i < rectangles.size(); ++i)
    ranges_[i] = {static_cast<std::uint8_t>(bit(rectangles[i].lo[axis])),
                  static_cast<std::uint8_t>(bit(rectangles[i].hi[axis]))};
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
      ordinals_.push_back(lo_ - 1 + place);
      bits_[place] = static_cast<std::uint8_t>(ordinals_.size());
    }
  bits_[0] = 0;
  bits_[extent_ + 1] = static_cast<std::uint8_t>(ordinals_.size() + 1);
}

void ContourCell::Places::find_by_sorting(std::span<const OrdinalRectangle> rectangles, unsigned axis) {
  for (const OrdinalRectangle& r : rectangles)
    for (const std::uint32_t ordinal : {r.lo[axis], r.hi[axis]})
      if (ordinal - lo_ < extent_) ordinals_.push_back(ordinal);
  std::ranges::sort(ordinals_);
  ordinals_.erase(std::unique(ordinals_.begin(), ordinals_.end()), ordinals_.end());
}

bool ContourCell::Places::assign(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
                                 unsigned axis) {
  lo_ = cell.lo[axis];
  extent_ = cell.hi[axis] - lo_;
  if (is_direct()) {
    count_ = extent_;
    set_ranges(rectangles, axis, [this](std::uint32_t ordinal) { return offset(ordinal); });
    return true;
  }
  ordinals_.clear();
  const bool by_marks = extent_ <= kMarked;
  by_marks ? find_by_marks(rectangles, axis) : find_by_sorting(rectangles, axis);
  count_ = static_cast<std::uint32_t>(ordinals_.size());
  if (count_ >= kBits) return false;
  if (by_marks)
    set_ranges(rectangles, axis, [this](std::uint32_t ordinal) { return bits_[offset(ordinal)]; });
  else
    set_ranges(rectangles, axis, [this](std::uint32_t ordinal) {
      const auto places = std::ranges::upper_bound(ordinals_, ordinal) - ordinals_.begin();
      return places + (ordinal >= lo_ + extent_);
    });
  return true;
}

std::uint64_t ContourCell::Places::occurring() const {
  const std::uint64_t owned = ~std::uint64_t{0} >> (kBits - 1 - count_) & ~std::uint64_t{1};
  if (!is_direct()) return owned;
  std::uint64_t bits = 0;
  for (const Range& r : ranges_)
    bits |= std::uint64_t{1} << r.begin % kBits | std::uint64_t{1} << r.end % kBits;  // bit 64 is not owned
  return bits & owned;
}

void ContourCell::find(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
                       Array<ContourVertex>& out) {
  constexpr std::size_t kMany = 512;
  if (rectangles.size() > kMany) {  // do some of them already need a smaller cell?
    std::vector<OrdinalRectangle> sample;
    for (std::size_t i = 0; i < rectangles.size(); i += rectangles.size() / (kMany / 2))
      sample.push_back(rectangles[i]);
    for (const unsigned axis : {0u, 1u})
      if (!places_[axis].assign(cell, sample, axis)) return halve(cell, rectangles, axis, out);
  }
  for (const unsigned axis : {0u, 1u}) {
    if (!places_[axis].assign(cell, rectangles, axis)) return halve(cell, rectangles, axis, out);
    if (places_[axis].count() == 0) return;
  }
  fill();
  emit(out);
}

/// Of the halves the lower one comes first, so that x ascends on every row.
void ContourCell::halve(const OrdinalRectangle& cell, std::span<const OrdinalRectangle> rectangles,
                        unsigned axis, Array<ContourVertex>& out) {
  Interruptible::check();
  const std::uint32_t middle = places_[axis].middle();
  std::vector<OrdinalRectangle> touching;
  for (const bool upper : {false, true}) {
    OrdinalRectangle half = cell;
    (upper ? half.lo : half.hi)[axis] = middle;
    if (std::ranges::any_of(rectangles, [&](const OrdinalRectangle& r) { return covers(r, half); })) continue;
    touching.clear();
    for (const OrdinalRectangle& r : rectangles)
      if (touches(r, half)) touching.push_back(r);
    find(half, touching, out);
  }
}

void ContourCell::fill() {
  std::fill_n(rows_.begin(), places_[1].count() + 1, 0);
  const std::span<const Places::Range> columns = places_[0].ranges(), rows = places_[1].ranges();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::uint64_t bits = ~std::uint64_t{0} >> (kBits - columns[i].end) & ~std::uint64_t{0}
                                                                                   << columns[i].begin;
    for (std::uint32_t row = rows[i].begin; row < rows[i].end; ++row) rows_[row] |= bits;
  }
}

void ContourCell::emit(Array<ContourVertex>& out) const {
  const auto &columns = places_[0], &rows = places_[1];
  const std::size_t before = out.size();
  out.resize(before + columns.count() * rows.count());
  ContourVertex* vertex = out.data() + before;
  const std::uint64_t owned = ~std::uint64_t{0} >> (kBits - columns.count());
  for (std::uint64_t rest = rows.occurring(); rest != 0; rest &= rest - 1) {
    const auto row = static_cast<std::uint32_t>(std::countr_zero(rest));
    const std::uint64_t below = rows_[row - 1], above = rows_[row], differ = below ^ above;
    const std::uint64_t along_x = (below ^ below >> 1) | (above ^ above >> 1), along_y = differ | differ >> 1;
    const std::uint32_t y = rows.ordinal(row - 1);
    for (std::uint64_t bits = along_x & along_y & owned; bits != 0; bits &= bits - 1) {
      const auto place = static_cast<std::uint32_t>(std::countr_zero(bits));
      *vertex++ = {columns.ordinal(place), y,
                   static_cast<std::uint32_t>((below >> place & 3) | (above >> place & 3) << 2)};
    }
  }
  out.resize(static_cast<std::size_t>(vertex - out.data()));
}

}  // namespace boxunion

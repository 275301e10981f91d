#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/radix_sort.hpp"

namespace boxunion {

/// A rectangle of a section, on B and C, and a mark for its owner.
template <class C>
struct SectionRectangle {
  C b_lo, c_lo, b_hi, c_hi;
  C mark;
};

/// A rectangle that a plane of vertices flips, or the bounds of several.
template <class C>
struct SectionCell {
  C b_lo, c_lo, b_hi, c_hi;
};

/// True if they have a point in common. Both are closed.
template <class C>
bool touch(const SectionRectangle<C>& r, const SectionCell<C>& cell) {
  return (r.b_hi >= cell.b_lo) & (r.c_lo <= cell.c_hi) & (r.c_hi >= cell.c_lo) & (r.b_lo <= cell.b_hi);
}

/// A filter for rectangles that may touch any of some cells, which are drawn on a grid of 64 x 64 squares.
template <class C>
class CellGrid {
 public:
  /// Takes the cells, at least one; fastest if they are sorted by b_lo.
  void assign(std::span<const SectionCell<C>> cells) {
    bounds_ = cells[0];
    for (const SectionCell<C>& cell : cells)
      bounds_ = {std::min(bounds_.b_lo, cell.b_lo), std::min(bounds_.c_lo, cell.c_lo),
                 std::max(bounds_.b_hi, cell.b_hi), std::max(bounds_.c_hi, cell.c_hi)};
    const auto shift = [](C length) { return std::max(0, int(std::bit_width(length)) - 6); };
    b_shift_ = shift(bounds_.b_hi - bounds_.b_lo);
    c_shift_ = shift(bounds_.c_hi - bounds_.c_lo);
    rows_.fill(0);
    spans_.clear();
    next_ = 0;
    for (const SectionCell<C>& cell : cells) {
      Span span{cell.b_lo, cell.b_hi};
      for (; !spans_.empty() && spans_.back().hi >= span.lo; spans_.pop_back())
        span = {std::min(span.lo, spans_.back().lo), std::max(span.hi, spans_.back().hi)};
      spans_.push_back(span);
      const std::uint64_t columns = this->columns(cell.c_lo, cell.c_hi);
      for (std::size_t row = this->row(cell.b_lo); row <= this->row(cell.b_hi); ++row) rows_[row] |= columns;
    }
  }

  /// False if a rectangle touches no cell. The rectangles must come in ascending order of b_lo.
  bool may_touch(const SectionRectangle<C>& r) {
    while (next_ < spans_.size() && spans_[next_].hi < r.b_lo) ++next_;
    if (next_ == spans_.size() || r.b_hi < spans_[next_].lo || !touch(r, bounds_)) return false;
    const std::size_t first = row(std::max(r.b_lo, bounds_.b_lo)), last = row(std::min(r.b_hi, bounds_.b_hi));
    std::uint64_t filled = rows_[first] | rows_[last];
    for (std::size_t i = first + 1; i < last; ++i) filled |= rows_[i];
    return (filled & columns(std::max(r.c_lo, bounds_.c_lo), std::min(r.c_hi, bounds_.c_hi))) != 0;
  }

 private:
  static constexpr std::size_t kSquares = 64;

  std::size_t row(C b) const { return std::size_t((b - bounds_.b_lo) >> b_shift_); }
  /// The columns that [c_lo, c_hi] touches, one bit for each.
  std::uint64_t columns(C c_lo, C c_hi) const {
    const std::uint64_t all = ~std::uint64_t{0};
    return all << ((c_lo - bounds_.c_lo) >> c_shift_) & all >> (63 - ((c_hi - bounds_.c_lo) >> c_shift_));
  }

  struct Span {
    C lo, hi;
  };

  SectionCell<C> bounds_{};
  std::vector<Span> spans_;  // on B, closed and sorted; together they cover all cells
  std::size_t next_ = 0;     // the first that does not end below
  int b_shift_ = 0, c_shift_ = 0;
  std::array<std::uint64_t, kSquares> rows_{};
};

/// Finds the rectangles that touch any of some cells, which may overlap. Takes O((n + m) log m) time for n
/// rectangles and m cells.
///
/// The rectangles come in descending order of b_lo, and the cells with b_hi >= b_lo are inserted on the way.
/// A rectangle touches one of these if, among those that it meets on C, the lowest b_lo is at most the
/// rectangle's b_hi. A tree over the gaps between the ends of the cells on C gives the lowest b_lo in any
/// range of gaps.
template <class C>
class CellReach {
 public:
  /// Takes the cells, at least one.
  void assign(std::span<const SectionCell<C>> cells) {
    cells_.assign(cells.begin(), cells.end());
    sorting_.resize(cells.size());
    radix_sort(std::span(cells_), std::span(sorting_), [](const SectionCell<C>& cell) { return cell.b_hi; });
    ends_.clear();
    for (const SectionCell<C>& cell : cells) ends_.insert(ends_.end(), {cell.c_lo, cell.c_hi});
    order_.resize(ends_.size());
    radix_sort(std::span(ends_), std::span(order_));
    ends_.erase(std::unique(ends_.begin(), ends_.end()), ends_.end());
    leaves_ = std::bit_ceil(ends_.size());
    lowest_.assign(2 * leaves_, kNone);
    whole_.assign(2 * leaves_, kNone);
  }

  /// True if a rectangle touches a cell. The rectangles must come in descending order of b_lo.
  bool touches(const SectionRectangle<C>& r) {
    for (; !cells_.empty() && cells_.back().b_hi >= r.b_lo; cells_.pop_back()) insert(cells_.back());
    if (r.c_hi < ends_.front() || r.c_lo > ends_.back()) return false;
    const auto first = std::lower_bound(ends_.begin() + 1, ends_.end() - 1, r.c_lo);
    const auto last = std::upper_bound(first, ends_.end() - 1, r.c_hi);
    return lowest(std::size_t(first - ends_.begin()) - 1, std::size_t(last - ends_.begin())) <= r.b_hi;
  }

  std::size_t bytes() const {
    return (cells_.capacity() + sorting_.capacity()) * sizeof(SectionCell<C>) +
           (ends_.capacity() + order_.capacity() + lowest_.capacity() + whole_.capacity()) * sizeof(C);
  }

 private:
  static constexpr C kNone = std::numeric_limits<C>::max();

  // gap i lies between ends_[i] and ends_[i + 1]; its leaf is leaves_ + i, the parent of node i is i / 2

  void insert(const SectionCell<C>& cell) {
    const auto first = std::lower_bound(ends_.begin(), ends_.end(), cell.c_lo);
    const auto last = std::lower_bound(first, ends_.end(), cell.c_hi);
    const std::size_t begin = leaves_ + std::size_t(first - ends_.begin()),
                      end = leaves_ + std::size_t(last - ends_.begin());
    const auto put = [&](std::size_t node) {
      whole_[node] = std::min(whole_[node], cell.b_lo);
      lowest_[node] = std::min(lowest_[node], cell.b_lo);
    };
    for (std::size_t i = begin, j = end; i < j; i /= 2, j /= 2) {
      if (i % 2 == 1) put(i++);
      if (j % 2 == 1) put(--j);
    }
    for (const std::size_t leaf : {begin, end - 1})
      for (std::size_t i = leaf / 2; i > 0; i /= 2) lowest_[i] = std::min(lowest_[i], cell.b_lo);
  }

  /// The lowest b_lo of the inserted cells that cover any of the gaps first .. last - 1.
  C lowest(std::size_t first, std::size_t last) const {
    C found = kNone;
    const std::size_t begin = leaves_ + first, end = leaves_ + last;
    for (std::size_t i = begin, j = end; i < j; i /= 2, j /= 2) {
      if (i % 2 == 1) found = std::min(found, lowest_[i++]);
      if (j % 2 == 1) found = std::min(found, lowest_[--j]);
    }
    for (const std::size_t leaf : {begin, end - 1})
      for (std::size_t i = leaf / 2; i > 0; i /= 2) found = std::min(found, whole_[i]);
    return found;
  }

  std::vector<SectionCell<C>> cells_, sorting_;  // not yet inserted, by b_hi
  std::vector<C> ends_, order_;                  // on C, distinct
  std::size_t leaves_ = 0;
  std::vector<C> lowest_, whole_;  // by node: lowest b_lo of cells that cover any of its gaps, or all
};

}  // namespace boxunion

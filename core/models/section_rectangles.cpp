#include "core/models/section_rectangles.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "core/base/parallel.hpp"
#include "core/base/radix_sort.hpp"

namespace boxunion {
namespace {

template <class... Vectors>
std::size_t bytes_of(const Vectors&... vectors) {
  return (... + (vectors.capacity() * sizeof(typename Vectors::value_type)));
}

}  // namespace

template <class C>
std::size_t SectionRectangles<C>::bytes() const {
  std::size_t bytes = sizeof(grid_) + reach_.bytes() + line_.bytes();
  for (const std::vector<Rectangle>& part : parts_) bytes += bytes_of(part);
  return bytes + bytes_of(rectangles_, planes_, cells_, touches_, plane_, touched_, renewed_, ends_, sorting_,
                          window_, begin_points_, end_points_, plane_points_, flips_);
}

/// Takes planes from the front until they make up a batch. Returns the number of their vertices.
template <class C>
std::size_t SectionRectangles<C>::take_batch(std::span<const Vertex> vertices) {
  const std::size_t wanted = batch();
  planes_.clear();
  cells_.clear();
  std::size_t count = 0;
  while (count < vertices.size() && count < wanted) {
    const std::size_t first = count;
    while (count < vertices.size() && vertices[count][0] == vertices[first][0]) ++count;
    planes_.push_back({&vertices[first], cells_.size()});
    project(vertices.subspan(first, count - first));
    add_cells();
  }
  planes_.push_back({vertices.data() + count, cells_.size()});
  return count;
}

/// Adds the cells of plane_: its own rectangles, or one around all of them if the plane is larger than the
/// section.
template <class C>
void SectionRectangles<C>::add_cells() {
  if (plane_.size() <= 4 || plane_.size() >= rectangles_.size()) {
    Cell bounds{plane_.front()[0], plane_.front()[1], plane_.back()[0], plane_.back()[1]};
    for (const auto& [b, c] : plane_) {
      bounds.c_lo = std::min(bounds.c_lo, c);
      bounds.c_hi = std::max(bounds.c_hi, c);
    }
    cells_.push_back(bounds);
  } else {
    renew({});
    for (const Rectangle& r : renewed_) cells_.push_back({r.b_lo, r.c_lo, r.b_hi, r.c_hi});
  }
}

/// True if it costs little to look at all rectangles for each of these planes.
template <class C>
bool SectionRectangles<C>::is_small(std::size_t first, std::size_t last, std::size_t rectangles) const {
  constexpr std::size_t kFewPlanes = 8, kLooks = 64;  // a look at a rectangle takes about a nanosecond
  const auto vertices = std::size_t(planes_[last].vertices - planes_[first].vertices);
  return last - first <= kFewPlanes || (last - first) * rectangles <= kLooks * vertices;
}

/// Moves the rectangles that planes first .. last - 1 touch from `list` to `touched`. For more than one
/// plane, it may move some more: a few for each cell.
template <class C>
void SectionRectangles<C>::take_touched(std::size_t first, std::size_t last, std::vector<Rectangle>& list,
                                        std::vector<Rectangle>& touched) {
  Interruptible::check();
  constexpr std::size_t kFew = 4, kMost = 32;  // rectangles for each cell
  touched.clear();
  if (list.size() <= kFew) return std::swap(list, touched);
  const auto cells = std::span(cells_).subspan(planes_[first].cell, planes_[last].cell - planes_[first].cell);
  C b_hi = 0;
  for (const Cell& cell : cells) b_hi = std::max(b_hi, cell.b_hi);
  const auto is_below = [&](const Rectangle& r) { return r.b_lo <= b_hi; };
  const auto count = std::size_t(std::partition_point(list.begin(), list.end(), is_below) - list.begin());
  const auto mark = [&](auto&& touches) {
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) found += touches_[i] = touches(list[i]);
    return found;
  };
  steps_ += count + cells.size();
  touches_.resize(std::max(count, touches_.size()));
  if (cells.size() == 1) {
    mark([&](const Rectangle& r) { return touch(r, cells[0]); });
  } else if (cells.size() <= kFew) {
    mark([&](const Rectangle& r) {
      return std::any_of(cells.begin(), cells.end(), [&](const Cell& cell) { return touch(r, cell); });
    });
  } else {
    grid_.assign(cells);
    const std::size_t found = mark([&](const Rectangle& r) { return grid_.may_touch(r); });
    if (found > kMost * cells.size() || (last - first > 1 && found > 0)) {
      reach_.assign(cells);
      for (std::size_t i = count; i-- > 0;)
        if (touches_[i] != 0) touches_[i] = reach_.touches(list[i]);
    }
  }
  take_marked(count, list, touched);
}

/// Of the first `count` rectangles of a list, moves those that are marked in touches_.
template <class C>
void SectionRectangles<C>::take_marked(std::size_t count, std::vector<Rectangle>& list,
                                       std::vector<Rectangle>& taken) {
  const auto next = [&](std::size_t i) {
    while (i < count && touches_[i] == 0) ++i;
    return i;
  };
  std::size_t i = next(0);
  auto out = list.begin() + std::ptrdiff_t(i);
  while (i < count) {
    taken.push_back(list[i]);
    const std::size_t begin = i + 1;
    i = next(begin);
    out = std::copy(list.begin() + std::ptrdiff_t(begin), list.begin() + std::ptrdiff_t(i), out);
  }
  list.erase(out, list.begin() + std::ptrdiff_t(count));
}

/// Sets plane_ to the vertices of a plane, without A.
template <class C>
void SectionRectangles<C>::project(std::span<const Vertex> plane) {
  plane_.clear();
  for (const Vertex& v : plane) plane_.push_back({v[1], v[2]});
}

/// Sweeps a line along B through the touched rectangles and plane_, and makes the new rectangles.
template <class C>
void SectionRectangles<C>::renew(std::span<const Rectangle> touched) {
  steps_ += touched.size() + plane_.size();
  ends_.clear();
  for (const Rectangle& r : touched) ends_.push_back({r.b_hi, r.c_lo, r.c_hi});
  sorting_.resize(ends_.size());
  radix_sort(std::span(ends_), std::span(sorting_), [](const HighEnd& end) {
    return PointKey()(OrderedPoint<2, C>{end.b_hi, end.c_lo});
  });

  renewed_.clear();
  line_.clear();
  auto begin = touched.begin();
  auto end = ends_.begin();
  auto point = plane_.begin();
  for (;;) {
    const C b = std::min({begin == touched.end() ? kEnd : begin->b_lo, end == ends_.end() ? kEnd : end->b_hi,
                          point == plane_.end() ? kEnd : (*point)[0]});
    if (b == kEnd) break;
    Interruptible::check();
    begin_points_.clear();
    end_points_.clear();
    plane_points_.clear();
    for (; begin != touched.end() && begin->b_lo == b; ++begin)
      begin_points_.insert(begin_points_.end(), {begin->c_lo, begin->c_hi});
    for (; end != ends_.end() && end->b_hi == b; ++end)
      end_points_.insert(end_points_.end(), {end->c_lo, end->c_hi});
    for (; point != plane_.end() && (*point)[0] == b; ++point) plane_points_.push_back((*point)[1]);
    find_flips();
    if (flips_.size() > 1) change_line(b);
  }
  steps_ += renewed_.size();
}

/// The points that are in one or all three of begin_points_, end_points_ and plane_points_. kEnd follows the
/// last point of each.
template <class C>
void SectionRectangles<C>::find_flips() {
  for (std::vector<C>* points : {&begin_points_, &end_points_, &plane_points_}) points->push_back(kEnd);
  const C *i = begin_points_.data(), *j = end_points_.data(), *k = plane_points_.data();
  flips_.clear();
  for (;;) {
    const C c = std::min({*i, *j, *k});
    if (c == kEnd) break;
    const bool in_begin = *i == c, in_end = *j == c, in_plane = *k == c;
    i += in_begin;
    j += in_end;
    k += in_plane;
    if (in_begin ^ in_end ^ in_plane) flips_.push_back(c);
  }
  flips_.push_back(kEnd);
}

/// Flips the intervals between points 0 and 1, 2 and 3, ... of flips_ on the line. Intervals that touch a
/// flip end or begin here; the others continue.
template <class C>
void SectionRectangles<C>::change_line(C b) {
  Place place;
  for (const C* flip = flips_.data(); *flip != kEnd;) place = change_intervals(b, place, flip);
}

/// The same for the next flip and all flips connected to it through intervals. All intervals before `place`
/// end below the flip. Returns the place behind the change.
template <class C>
auto SectionRectangles<C>::change_intervals(C b, Place place, const C*& flip) -> Place {
  const C lowest = *flip;
  const Place first = line_.find_from(place, [&](const Interval& i) { return i.c_hi < lowest; });
  place = first;
  window_.clear();
  std::size_t count = 0;
  C next_flip = lowest, next_old = line_.is_end(place) ? kEnd : line_[place].c_lo;
  bool in_flip = false, in_old = false, in_new = false;
  do {
    const C c = std::min(next_flip, next_old);
    const bool flips = next_flip == c, changes = next_old == c;
    if (flips) {
      in_flip = !in_flip;
      next_flip = *++flip;
    }
    if (changes) {
      in_old = !in_old;
      if (in_old) {
        next_old = line_[place].c_hi;
        renewed_[line_[place].rectangle].b_hi = b;
        ++count;
      } else {
        place = line_.next(place);
        next_old = line_.is_end(place) ? kEnd : line_[place].c_lo;
      }
    }
    if (flips == changes) continue;
    in_new = !in_new;
    if (in_new) {
      window_.push_back({c, c, renewed_.size()});
      renewed_.push_back({b, c, b, c, 0});
    } else {
      window_.back().c_hi = renewed_.back().c_hi = c;
    }
  } while (in_flip || in_old);
  return line_.replace(first, count, window_);
}

/// Merges sorted rectangles into a sorted list.
template <class C>
void SectionRectangles<C>::put_back(std::span<const Rectangle> rectangles, std::vector<Rectangle>& list) {
  std::size_t rest = list.size(), out = rest + rectangles.size();
  list.resize(out);
  const auto first = list.begin();
  for (std::size_t j = rectangles.size(); j-- > 0;) {
    const auto corner = low_corner(rectangles[j]);
    std::size_t begin = rest;  // of those behind this one
    for (std::size_t step = 1; begin > 0 && corner < low_corner(list[begin - 1]); step *= 2)
      begin -= std::min(step, begin);
    begin = std::size_t(std::partition_point(first + std::ptrdiff_t(begin), first + std::ptrdiff_t(rest),
                                             [&](const Rectangle& r) { return low_corner(r) < corner; }) -
                        first);
    std::copy_backward(first + std::ptrdiff_t(begin), first + std::ptrdiff_t(rest),
                       first + std::ptrdiff_t(out));
    out -= rest - begin;
    rest = begin;
    list[--out] = rectangles[j];
  }
  steps_ += list.size() - out;
}

template class SectionRectangles<std::uint32_t>;
template class SectionRectangles<std::uint64_t>;

}  // namespace boxunion

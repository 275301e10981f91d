#include "core/section_rectangles.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

#include "core/radix_sort.hpp"

namespace boxunion {
namespace {

template <class... Vectors>
std::size_t bytes_of(const Vectors&... vectors) {
  return (... + (vectors.capacity() * sizeof(typename Vectors::value_type)));
}

}  // namespace

template <class C>
std::size_t SectionRectangles<C>::bytes() const {
  return bytes_of(rectangles_, changes_, touched_, untouched_, renewed_, merged_, ends_, sorting_, line_,
                  window_, begin_points_, end_points_, plane_points_, moved_, flips_, old_points_,
                  new_points_);
}

template <class C>
void SectionRectangles<C>::find_changes(const ExtremeVertices<2, C>& plane) {
  changes_.clear();
  const bool divided = plane.size() <= rectangles_.size();  // else gaps would not pay
  ExtremeVertices<1, C>& inside = old_points_;              // what is flipped behind the line
  inside.clear();
  for (auto point = plane.begin(); point != plane.end();) {
    const C b = (*point)[0];
    plane_points_.clear();
    for (; point != plane.end() && (*point)[0] == b; ++point) plane_points_.push_back({(*point)[1]});
    if (changes_.empty() || (divided && inside.empty()))
      changes_.push_back({b, plane_points_.front()[0], b, plane_points_.back()[0]});
    Bounds& bounds = changes_.back();
    bounds.b_hi = b;
    bounds.c_lo = std::min(bounds.c_lo, plane_points_.front()[0]);
    bounds.c_hi = std::max(bounds.c_hi, plane_points_.back()[0]);
    if (!divided) continue;
    exclusive_or(inside, plane_points_, new_points_);
    std::swap(inside, new_points_);
  }
}

template <class C>
void SectionRectangles<C>::take_touched() {
  constexpr std::size_t kMostTests = 8;  // a rectangle that more changes may reach is taken for touched
  touched_.clear();
  untouched_.clear();
  std::size_t i = 0;
  for (const Rectangle& r : rectangles_) {
    while (i < changes_.size() && changes_[i].b_hi < r.b_lo) ++i;
    bool touches = false;
    for (std::size_t k = i; k < changes_.size() && changes_[k].b_lo <= r.b_hi && !touches; ++k)
      touches = k == i + kMostTests || (changes_[k].c_lo <= r.c_hi && changes_[k].c_hi >= r.c_lo);
    (touches ? touched_ : untouched_).push_back(r);
  }
}

/// Sweeps a line along B through the touched rectangles and the plane that changes them.
template <class C>
void SectionRectangles<C>::renew(const ExtremeVertices<2, C>& plane) {
  ends_.clear();
  for (const Rectangle& r : touched_) ends_.push_back({r.b_hi, r.c_lo, r.c_hi});
  sorting_.resize(ends_.size());
  radix_sort(std::span(ends_), std::span(sorting_), [](const HighEnd& end) {
    return PointKey()(OrderedPoint<2, C>{end.b_hi, end.c_lo});
  });

  renewed_.clear();
  line_.clear();
  auto begin = touched_.begin();
  auto end = ends_.begin();
  auto point = plane.begin();
  constexpr C kEnd = std::numeric_limits<C>::max();
  for (;;) {
    const C b = std::min({begin == touched_.end() ? kEnd : begin->b_lo, end == ends_.end() ? kEnd : end->b_hi,
                          point == plane.end() ? kEnd : (*point)[0]});
    if (b == kEnd) break;
    begin_points_.clear();
    end_points_.clear();
    plane_points_.clear();
    for (; begin != touched_.end() && begin->b_lo == b; ++begin)
      begin_points_.insert(begin_points_.end(), {{begin->c_lo}, {begin->c_hi}});
    for (; end != ends_.end() && end->b_hi == b; ++end)
      end_points_.insert(end_points_.end(), {{end->c_lo}, {end->c_hi}});
    for (; point != plane.end() && (*point)[0] == b; ++point) plane_points_.push_back({(*point)[1]});
    exclusive_or(begin_points_, end_points_, moved_);
    exclusive_or(moved_, plane_points_, flips_);
    if (!flips_.empty()) change_line(b, flips_);
  }
}

/// Flips the intervals between points 0 and 1, 2 and 3, ... on the line. Intervals that touch one of these
/// end here or begin here, the others go on.
template <class C>
void SectionRectangles<C>::change_line(C b, const ExtremeVertices<1, C>& flips) {
  const C lowest = flips.front()[0], highest = flips.back()[0];
  const auto first =
      std::partition_point(line_.begin(), line_.end(), [&](const Interval& i) { return i.c_hi < lowest; });
  const auto last =
      std::partition_point(first, line_.end(), [&](const Interval& i) { return i.c_lo <= highest; });
  old_points_.clear();
  for (auto i = first; i != last; ++i) old_points_.insert(old_points_.end(), {{i->c_lo}, {i->c_hi}});
  exclusive_or(old_points_, flips, new_points_);

  window_.clear();
  auto old = first;
  auto flip = flips.begin();
  for (auto p = new_points_.begin(); p != new_points_.end(); p += 2) {
    const C c_lo = p[0][0], c_hi = p[1][0];
    while (flip != flips.end() && flip[1][0] < c_lo) flip += 2;
    if (flip != flips.end() && flip[0][0] <= c_hi) {
      window_.push_back({c_lo, c_hi, renewed_.size()});
      renewed_.push_back({b, c_lo, b, c_hi, 0});
    } else {
      for (; old->c_lo < c_lo; ++old) renewed_[old->rectangle].b_hi = b;
      window_.push_back(*old++);
    }
  }
  for (; old != last; ++old) renewed_[old->rectangle].b_hi = b;

  const auto both = std::min(last - first, std::ptrdiff_t(window_.size()));
  const auto rest = std::copy(window_.begin(), window_.begin() + both, first);
  if (rest != last)
    line_.erase(rest, last);
  else
    line_.insert(rest, window_.begin() + both, window_.end());
}

template <class C>
void SectionRectangles<C>::put_back() {
  merged_.clear();
  std::merge(untouched_.begin(), untouched_.end(), renewed_.begin(), renewed_.end(),
             std::back_inserter(merged_),
             [](const Rectangle& p, const Rectangle& q) { return low_corner(p) < low_corner(q); });
  std::swap(rectangles_, merged_);
}

template class SectionRectangles<std::uint32_t>;
template class SectionRectangles<std::uint64_t>;

}  // namespace boxunion

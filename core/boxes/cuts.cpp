#include "core/boxes/cuts.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace boxunion {
namespace {

constexpr double kNotablyFewer = 0.9, kFewCopies = 1.5;
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// The sorted ends of the boxes of a sample on one axis.
struct Ends {
  std::vector<double> lo, hi;

  Ends(std::span<const Box> sample, unsigned axis) {
    for (const Box& box : sample) lo.push_back(box[axis]), hi.push_back(box[axis + 3]);
    std::ranges::sort(lo);
    std::ranges::sort(hi);
  }
  std::size_t begun_before(double x) const {
    return std::size_t(std::ranges::lower_bound(lo, x) - lo.begin());
  }
  std::size_t ended_before(double x) const {
    return std::size_t(std::ranges::lower_bound(hi, x) - hi.begin());
  }
  /// The next coordinate after x at which a box begins or ends.
  double next(double x) const {
    const auto begin = std::ranges::upper_bound(lo, x), end = std::ranges::upper_bound(hi, x);
    return std::min(begin == lo.end() ? kNoEnd : *begin, end == hi.end() ? kNoEnd : *end);
  }
};

/// Slabs from the low end on, each as long as possible with no more than `count` boxes of the sample.
Cuts cut_axis(const Ends& ends, int axis, std::size_t count, std::size_t most) {
  Cuts cuts;
  cuts.axis = axis;
  const std::size_t size = ends.lo.size();
  std::size_t largest = 0, all = 0;
  for (double begin = -kNoEnd, end; begin < kNoEnd; begin = end) {
    const std::size_t before = ends.ended_before(begin);
    end = kNoEnd;
    if (cuts.at.size() + 1 < most && before + count < size) {
      end = ends.lo[before + count];
      if (end <= begin || end == ends.lo.front()) end = ends.next(std::max(begin, ends.lo.front()));
    }
    const std::size_t here = ends.begun_before(end) - before;
    largest = std::max(largest, here);
    all += here;
    if (end < kNoEnd) cuts.at.push_back(end);
  }
  cuts.largest = double(largest) / double(size);
  cuts.copies = double(all) / double(size);
  return cuts;
}

}  // namespace

std::optional<Cuts> choose_cuts(std::span<const Box> sample, double share, std::size_t most) {
  if (sample.empty()) return std::nullopt;
  const std::array ends = {Ends(sample, 0), Ends(sample, 1), Ends(sample, 2)};
  std::optional<Cuts> best;
  // Begin with a share so large that the last slab is no larger than the others. Increase it if boxes are
  // longer than slabs.
  for (share = std::max(share, 1.1 / double(most)); share < 1; share *= 2) {
    const auto count = std::max<std::size_t>(1, std::size_t(share * double(sample.size())));
    for (const int axis : {2, 1, 0}) {
      const Cuts cuts = cut_axis(ends[unsigned(axis)], axis, count, most);
      if (cuts.largest <= kNotablyFewer && (!best || cuts.copies < best->copies)) best = cuts;
    }
    if (best && best->copies <= kFewCopies) break;
  }
  return best;
}

}  // namespace boxunion

#include "core/anchored/staircase.hpp"

#include <algorithm>

#include "core/base/radix_sort.hpp"

namespace boxunion {

StairSweep::StairSweep(Array<AnchoredBox> boxes) {
  constexpr auto kWhat = "sorting boxes with a common corner";
  std::erase_if(boxes, [](const AnchoredBox& box) { return box.u == 0 || box.v == 0 || box.w == 0; });
  radix_sort(std::span(boxes), [](const AnchoredBox& box) { return ~box.u; });
  steps_ = make_array<Step>(boxes.size(), kWhat);
  u_ = make_array<std::uint64_t>(boxes.size(), kWhat);
  std::uint32_t ranks = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const AnchoredBox& box = boxes[i];
    if (ranks == 0 || u_[ranks - 1] != box.u) u_[ranks++] = box.u;
    steps_[i] = {box.w, box.v, ranks - 1};
    bounds_ = {u_[0], std::max(bounds_.v, box.v), std::max(bounds_.w, box.w)};
  }
  u_.resize(ranks);
  radix_sort(std::span(steps_), [](const Step& step) { return ~step.w; });
}

std::size_t StairSweep::parts() const {
  constexpr std::size_t kLeast = 1 << 8;  // boxes
  return std::clamp(size() / kLeast, std::size_t{1}, thread_count());
}

std::size_t StairSweep::begin(std::size_t part, std::size_t parts) const {
  std::size_t step = size() * part / parts;
  while (0 < step && step < size() && steps_[step - 1].w == steps_[step].w) ++step;
  return step;
}

StairSweep::Front StairSweep::front_before(std::size_t step) const {
  Front front(u_.size());
  if (step == 0) return front;
  for (std::size_t i = 0; i < step; ++i) {
    std::uint64_t& height = front.heights[steps_[i].rank];
    height = std::max(height, steps_[i].v);
  }
  std::uint64_t height = 0;
  for (std::uint32_t rank = 0; rank < u_.size(); ++rank) {
    if (front.heights[rank] <= height) continue;
    height = front.heights[rank];
    front.corners.insert(rank);
  }
  return front;
}

}  // namespace boxunion

#include "core/anchored/anchored.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/anchored/staircase.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kGrain = 1 << 14;  // boxes

/// The coordinates that all boxes share: bit k is set if at(box, k) is the same for all boxes.
template <class At>
unsigned shared_coordinates(const At& at, std::size_t begin, std::size_t end) {
  unsigned shared = 63;
  for (std::size_t i = begin; i < end; ++i) {
    for (unsigned k = 0; k < 6; ++k) shared &= ~(unsigned(at(i, k) != at(0, k)) << k);
    if (((shared | shared >> 3) & 7) != 7) return 0;
  }
  return shared;
}

/// The corner that boxes 0 .. size - 1 share, if there is one.
template <class At>
std::optional<CommonCorner> common_corner(std::size_t size, const At& at) {
  const std::size_t first = std::min<std::size_t>(64, size);
  unsigned shared = first == 0 ? 0 : shared_coordinates(at, 0, first);
  if (shared != 0 && first < size)
    shared = parallel_reduce(
        first, size, kGrain, shared,
        [&](std::size_t begin, std::size_t end, unsigned before) {
          return before == 0 ? 0 : before & shared_coordinates(at, begin, end);
        },
        std::bit_and<>());
  if (((shared | shared >> 3) & 7) != 7 || size > StairSweep::kMost) return std::nullopt;
  return CommonCorner{(shared >> 3 & 1u) != 0, (shared >> 4 & 1u) != 0, (shared >> 5 & 1u) != 0};
}

/// The octant mask that each mask becomes when some axes are reversed.
std::array<std::uint8_t, 256> turned_masks(const CommonCorner& turned) {
  const unsigned axes = unsigned(turned[0]) + 2 * unsigned(turned[1]) + 4 * unsigned(turned[2]);
  std::array<std::uint8_t, 256> masks{};
  for (unsigned mask = 0; mask < 256; ++mask)
    for (unsigned octant = 0; octant < 8; ++octant)
      masks[mask] = std::uint8_t(masks[mask] | (mask >> octant & 1u) << (octant ^ axes));
  return masks;
}

/// Maps vertices from u, v, w to ordinals and passes them on.
class VertexVisitor {
 public:
  VertexVisitor(const std::array<std::uint32_t, 3>& at, const CommonCorner& turned, VertexSink& sink)
      : at_(at), turned_(turned), masks_(turned_masks(turned)), sink_(&sink) {}

  void column(const StairColumn& column) {
    each_vertex(column, [&](std::uint64_t v, unsigned mask) {
      vertices_.push_back({ordinal(0, column.u), ordinal(1, v), 0, masks_[mask]});
    });
  }
  void plane(std::uint64_t w) {
    for (; done_ < vertices_.size(); ++done_) vertices_[done_].z = ordinal(2, w);
    if (done_ >= kBatch) flush();
  }
  void flush() {
    sink_->add(vertices_);
    vertices_.clear();
    done_ = 0;
  }

 private:
  static constexpr std::size_t kBatch = 1 << 12;

  std::uint32_t ordinal(std::size_t axis, std::uint64_t reach) const {
    const auto steps = static_cast<std::uint32_t>(reach);
    return turned_[axis] ? at_[axis] - steps : at_[axis] + steps;
  }

  std::array<std::uint32_t, 3> at_;  // the shared corner
  CommonCorner turned_;
  std::array<std::uint8_t, 256> masks_;
  VertexSink* sink_;
  std::vector<Vertex> vertices_;
  std::size_t done_ = 0;  // number of vertices whose plane is complete
};

}  // namespace

std::optional<CommonCorner> find_common_corner(const BoxSet& set) {
  return set.visit([](const auto& boxes) {
    return common_corner(boxes.size(), [&](std::size_t i, unsigned k) { return boxes[i][k]; });
  });
}

std::optional<CommonCorner> find_common_corner(std::span<const OrdinalBox> boxes) {
  return common_corner(
      boxes.size(), [&](std::size_t i, unsigned k) { return k < 3 ? boxes[i].lo[k] : boxes[i].hi[k - 3]; });
}

void unite_anchored(std::span<const OrdinalBox> boxes, const CommonCorner& corner, VertexSink& sink) {
  if (boxes.empty()) return;
  std::array<std::uint32_t, 3> at;
  for (unsigned a = 0; a < 3; ++a) at[a] = corner[a] ? boxes[0].hi[a] : boxes[0].lo[a];
  auto reaches = make_array<AnchoredBox>(boxes.size(), "boxes with a common corner");
  parallel_for_each(0, boxes.size(), kGrain, [&](std::size_t i) {
    const auto& [lo, hi] = boxes[i];
    reaches[i] = {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
  });
  const StairSweep sweep(std::move(reaches));
  std::vector<VertexVisitor> visitors(sweep.parts(), VertexVisitor(at, corner, sink));
  sweep.sweep(std::span(visitors));
  for (VertexVisitor& visitor : visitors) visitor.flush();
}

}  // namespace boxunion

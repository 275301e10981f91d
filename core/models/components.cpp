#include "boxunion/components.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "boxunion/error.hpp"
#include "core/base/disjoint_sets.hpp"
#include "core/base/exact.hpp"
#include "core/base/interruptible.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/models/box_faces.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// An exact sum of the volumes of boxes.
class VolumeSum {
 public:
  /// `axes` are in the order of the coordinates of the boxes.
  explicit VolumeSum(const std::array<const Axis*, 3>& axes) : axes_(axes) {
    for (const Axis* axis : axes_) {
      lattice_ = lattice_ && axis->is_lattice();
      exponent_ += axis->exponent();
    }
  }
  void add(const OrdinalBox& box) {
    if (lattice_) {
      UInt128 volume = 1;
      for (std::size_t i = 0; i < 3; ++i) volume *= box.hi[i] - box.lo[i];
      steps_ += volume;  // room for 2^32 boxes of 2^96
    } else {
      Dyadic volume{1, 0};
      for (std::size_t i = 0; i < 3; ++i)
        volume = volume * (dyadic(axes_[i]->coordinate(box.hi[i])) - dyadic(axes_[i]->coordinate(box.lo[i])));
      total_ = total_ + volume;
    }
  }
  double result() const { return round_to_double(lattice_ ? Dyadic{BigInteger(steps_), exponent_} : total_); }

 private:
  std::array<const Axis*, 3> axes_;
  bool lattice_ = true;
  int exponent_ = 0;
  UInt128 steps_ = 0;
  Dyadic total_;
};

/// Numbers the sets of boxes in the order of their first boxes.
Labels number_sets(DisjointSets& sets, std::uint32_t boxes) {
  Labels result;
  with_memory("the labels", boxes * sizeof(std::uint32_t), [&] { result.labels.resize(boxes); });
  interruptible_loop(boxes, [&](std::size_t i) {
    const std::uint32_t first = sets.find(std::uint32_t(i));
    result.labels[i] = first == i ? ++result.count : result.labels[first];
  });
  return result;
}

}  // namespace

Labels label_components(const Adjacency& adjacency) {
  const std::size_t offsets = adjacency.backward[0].offsets.size();
  if (offsets != adjacency.backward[1].offsets.size())
    throw Error(ErrorKind::usage, "the neighbor lists of the two axes are for different numbers of boxes");
  if (offsets == 0) return {};
  const auto boxes = std::uint32_t(offsets - 1);
  DisjointSets sets(boxes, "joining boxes");
  parallel_for_each(0, boxes, kGrain, [&](std::size_t i) {
    for (const NeighborLists& lists : adjacency.backward)
      for (const std::uint32_t other : lists[i]) sets.join(std::uint32_t(i), other);
  });
  return number_sets(sets, boxes);
}

Labels label_components(const Decomposition& decomposition, Connectivity connectivity) {
  validate(connectivity);
  const auto boxes = std::uint32_t(decomposition.boxes.size());
  DisjointSets sets(boxes, "joining boxes");
  for (std::size_t axis = 0; axis < 2; ++axis)
    join_boxes<FacePairs::enough>(decomposition, connectivity, axis, [&] {
      return [&](std::uint32_t below, std::uint32_t above) { sets.join(below, above); };
    });
  return number_sets(sets, boxes);
}

std::vector<Component> measure_components(const Decomposition& decomposition, const Labels& labels) {
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  validate(decomposition.order);
  if (labels.labels.size() != boxes.size())
    throw Error(ErrorKind::usage, fmt::format("{} boxes were given {} labels, expected as many", boxes.size(),
                                              labels.labels.size()));
  for (const std::uint32_t label : labels.labels)
    if (label < 1 || label > labels.count)
      throw Error(ErrorKind::usage, fmt::format("a box has label {}, expected 1 to {}", label, labels.count));
  std::vector<std::size_t> next(std::size_t{labels.count} + 1, 0);  // by label: the place of the next box
  interruptible_loop(boxes.size(), [&](std::size_t i) { ++next[labels.labels[i]]; });
  std::partial_sum(next.begin(), next.end(), next.begin());
  Array<std::uint32_t> sorted;  // boxes by label
  with_memory("the components", boxes.size() * sizeof(std::uint32_t), [&] { sorted.resize(boxes.size()); });
  interruptible_loop(boxes.size(),
                     [&](std::size_t i) { sorted[next[labels.labels[i] - 1]++] = std::uint32_t(i); });

  std::array<const Axis*, 3> axes{};
  for (std::size_t i = 0; i < 3; ++i) axes[i] = &decomposition.axes[decomposition.order[i]];
  std::vector<Component> components(labels.count);
  parallel_for_each(0, labels.count, 64, [&](std::size_t c) {
    const std::size_t first = c == 0 ? 0 : next[c - 1];
    VolumeSum volume(axes);
    OrdinalBox bounds = boxes[sorted[first]];
    for (std::size_t k = first; k < next[c]; ++k) {
      const OrdinalBox& box = boxes[sorted[k]];
      volume.add(box);
      for (std::size_t i = 0; i < 3; ++i) {
        bounds.lo[i] = std::min(bounds.lo[i], box.lo[i]);
        bounds.hi[i] = std::max(bounds.hi[i], box.hi[i]);
      }
    }
    components[c].boxes = next[c] - first;
    components[c].volume = volume.result();
    for (std::size_t i = 0; i < 3; ++i) {
      components[c].bounds[0][decomposition.order[i]] = axes[i]->coordinate(bounds.lo[i]);
      components[c].bounds[1][decomposition.order[i]] = axes[i]->coordinate(bounds.hi[i]);
    }
  });
  return components;
}

std::vector<Component> measure_components(const VoxelGrid& grid, std::span<const VoxelComponent> components) {
  Dyadic voxel{1, 0};
  for (const double edge : grid.spacing) voxel = voxel * dyadic(std::abs(edge));
  std::vector<Component> result(components.size());
  parallel_for_each(0, components.size(), 1 << 10, [&](std::size_t c) {
    result[c].boxes = components[c].voxels;
    result[c].volume = round_to_double(Dyadic{BigInteger(components[c].voxels), 0} * voxel);
    for (std::size_t a = 0; a < 3; ++a) {
      const double first = grid.edge(a, components[c].first[a]),
                   last = grid.edge(a, components[c].last[a] + 1);
      result[c].bounds[0][grid.axes[a]] = std::min(first, last);
      result[c].bounds[1][grid.axes[a]] = std::max(first, last);
    }
  });
  return result;
}

}  // namespace boxunion

#include "core/components.hpp"

#include <algorithm>
#include <numeric>

#include "core/disjoint_sets.hpp"
#include "core/exact.hpp"
#include "core/memory.hpp"
#include "core/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// Adds up volumes of boxes, exactly.
class VolumeSum {
 public:
  /// `axes` in the order of the boxes.
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
      steps_ += volume;  // 2^32 boxes of 2^96 fit
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

}  // namespace

Components find_components(const Decomposition& decomposition, const Adjacency& adjacency) {
  const std::vector<OrdinalBox>& boxes = decomposition.boxes;
  DisjointSets sets(std::uint32_t(boxes.size()), "joining boxes");
  parallel_ranges(0, boxes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (const NeighborLists& lists : adjacency.backward)
      for (std::size_t i = begin; i < end; ++i)
        for (const std::uint32_t other : lists[i]) sets.join(std::uint32_t(i), other);
  });

  Components result;
  with_memory("the labels", boxes.size() * sizeof(std::uint32_t),
              [&] { result.labels.resize(boxes.size()); });
  std::vector<std::size_t> counts;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const std::uint32_t root = sets.find(i);  // the lowest of its set
    if (root == i) counts.push_back(0);
    const std::uint32_t label = root == i ? std::uint32_t(counts.size()) : result.labels[root];
    result.labels[i] = label;
    ++counts[label - 1];
  }
  result.components.resize(counts.size());

  // the boxes by label, then each component by itself
  std::vector<std::size_t> starts(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  Array<std::uint32_t> sorted;
  with_memory("the components", boxes.size() * sizeof(std::uint32_t), [&] { sorted.resize(boxes.size()); });
  std::vector<std::size_t> next(starts.begin(), starts.end() - 1);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) sorted[next[result.labels[i] - 1]++] = i;
  std::array<const Axis*, 3> axes{};
  for (std::size_t i = 0; i < 3; ++i) axes[i] = &decomposition.axes[decomposition.order[i]];
  parallel_ranges(0, counts.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      VolumeSum volume(axes);
      OrdinalBox bounds = boxes[sorted[starts[c]]];
      for (std::size_t k = starts[c]; k < starts[c + 1]; ++k) {
        const OrdinalBox& box = boxes[sorted[k]];
        volume.add(box);
        for (std::size_t i = 0; i < 3; ++i) {
          bounds.lo[i] = std::min(bounds.lo[i], box.lo[i]);
          bounds.hi[i] = std::max(bounds.hi[i], box.hi[i]);
        }
      }
      Components::Properties& properties = result.components[c];
      properties.boxes = counts[c];
      properties.volume = volume.result();
      for (std::size_t i = 0; i < 3; ++i) {
        properties.bounds[0][decomposition.order[i]] = axes[i]->coordinate(bounds.lo[i]);
        properties.bounds[1][decomposition.order[i]] = axes[i]->coordinate(bounds.hi[i]);
      }
    }
  });
  return result;
}

}  // namespace boxunion

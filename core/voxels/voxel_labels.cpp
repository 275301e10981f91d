#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "boxunion/error.hpp"
#include "boxunion/voxels.hpp"
#include "core/base/disjoint_sets.hpp"
#include "core/base/parallel.hpp"
#include "core/voxels/voxel_runs.hpp"

namespace boxunion {
namespace {

/// Joins the runs of two rows that overlap, or come within `reach` voxels of overlapping.
void join_rows(const VoxelRuns& runs, std::size_t row, std::size_t other_row, std::uint32_t reach,
               DisjointSets& sets) {
  std::size_t a = runs.start(row), b = runs.start(other_row);
  const std::size_t a_end = runs.start(row + 1), b_end = runs.start(other_row + 1);
  while (a < a_end && b < b_end) {
    const Run of_a = runs[a], of_b = runs[b];
    if (of_a.begin < of_b.end + reach && of_b.begin < of_a.end + reach)
      sets.join(std::uint32_t(a), std::uint32_t(b));
    const bool a_ends_first = of_a.end < of_b.end;
    a += a_ends_first;
    b += !a_ends_first;
  }
}

/// Joins the runs of a row with those of neighboring rows before it.
void join_neighbors(const VoxelRuns& runs, std::size_t row, std::size_t height, Connectivity connectivity,
                    DisjointSets& sets) {
  const std::size_t y = row % height;
  const bool is_first_slice = row < height;
  const std::uint32_t reach = connectivity == Connectivity::points ? 1 : 0;
  if (y > 0) join_rows(runs, row, row - 1, reach, sets);
  if (is_first_slice) return;
  join_rows(runs, row, row - height, reach, sets);
  if (connectivity == Connectivity::faces) return;
  if (y > 0) join_rows(runs, row, row - height - 1, reach, sets);
  if (y + 1 < height) join_rows(runs, row, row - height + 1, reach, sets);
}

/// Counts the voxels of each component, run by run.
class ComponentCounter {
 public:
  void add(std::uint32_t label, const Run& run, std::uint32_t y, std::uint32_t z) {
    if (label > components_.size()) components_.push_back({0, {run.begin, y, z}, {run.end - 1, y, z}});
    VoxelComponent& c = components_[label - 1];
    c.voxels += run.end - run.begin;
    c.first = {std::min(c.first[0], run.begin), std::min(c.first[1], y), c.first[2]};
    c.last = {std::max(c.last[0], run.end - 1), std::max(c.last[1], y), z};
  }
  std::vector<VoxelComponent> take() { return std::move(components_); }

 private:
  std::vector<VoxelComponent> components_;
};

}  // namespace

std::vector<VoxelComponent> label_voxels(const Volume& volume, Connectivity connectivity,
                                         std::span<std::uint32_t> labels) {
  validate(volume);
  validate(connectivity);
  if (labels.size() != volume.inside.size())
    throw Error(ErrorKind::usage, fmt::format("a volume of {} voxels was given {} labels, expected as many",
                                              volume.inside.size(), labels.size()));
  if (labels.empty()) return {};
  const auto [width, height, depth] = volume.grid.size;
  const VoxelRuns runs(volume.inside, width);
  if (runs.size() >= std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorKind::resources, "the volume has 2^32 - 1 runs of voxels or more, too many to label");
  const std::size_t rows = runs.rows(),
                    grain = std::max<std::size_t>((std::size_t{1} << 16) / (width + 1), 1);

  DisjointSets sets(std::uint32_t(runs.size()), "joining voxels");
  parallel_for_each(0, rows, grain, [&, height = height](std::size_t row) {
    join_neighbors(runs, row, height, connectivity, sets);
  });

  // Parents are lower than their children, so the parents of earlier runs have become labels already.
  Array<std::uint32_t> run_labels = sets.take_parents();
  ComponentCounter counter;
  std::uint32_t count = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    Interruptible::check();
    for (std::size_t r = runs.start(row); r < runs.start(row + 1); ++r) {
      run_labels[r] = run_labels[r] == r ? ++count : run_labels[run_labels[r]];
      counter.add(run_labels[r], runs[r], std::uint32_t(row % height), std::uint32_t(row / height));
    }
  }

  parallel_for_each(0, rows, grain, [&, width = width](std::size_t row) {
    std::uint32_t* const voxels = labels.data() + row * width;
    std::fill_n(voxels, width, 0u);
    for (std::size_t r = runs.start(row); r < runs.start(row + 1); ++r)
      std::fill(voxels + runs[r].begin, voxels + runs[r].end, run_labels[r]);
  });
  return counter.take();
}

}  // namespace boxunion

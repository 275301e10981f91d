// Small boxes of every family. Results equal those of brute force and of the other method, in every order of
// rows, and the work grows no faster than input and output.

#include "tests/support/families.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/union.hpp"
#include "tests/engine/ways.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

class Families : public testing::TestWithParam<Family> {
 protected:
  static BoxSet boxes(std::size_t size, RowOrder order = RowOrder::given) {
    return reorder(GetParam().make(size), order);
  }
};

const Options kAutomatic{.device = "native"};
const Options kCells{.method = Method::cells, .device = "native"};
const Options kSlices{.method = Method::slices, .device = "native"};

std::vector<Box> doubles(const BoxSet& boxes) {
  std::vector<Box> all;
  for (std::size_t i = 0; i < boxes.size(); ++i) all.push_back(boxes[i]);
  return all;
}

/// True if two boxes have points in common (of a face, if `faces`). Their interiors are disjoint.
bool touch(const OrdinalBox& a, const OrdinalBox& b, bool faces) {
  int touching = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.hi[axis] < b.lo[axis] || b.hi[axis] < a.lo[axis]) return false;
    touching += a.hi[axis] == b.lo[axis] || b.hi[axis] == a.lo[axis];
  }
  return faces ? touching == 1 : touching > 0;
}

bool overlap(const OrdinalBox& a, const OrdinalBox& b) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (a.hi[axis] <= b.lo[axis] || b.hi[axis] <= a.lo[axis]) return false;
  return true;
}

/// The labels of boxes, found from all pairs.
std::vector<std::uint32_t> brute_force_labels(const std::vector<OrdinalBox>& boxes,
                                              Connectivity connectivity) {
  std::vector<std::uint32_t> first(boxes.size());  // first box of the component
  std::iota(first.begin(), first.end(), 0u);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (first[i] != first[j] && touch(boxes[i], boxes[j], connectivity == Connectivity::faces)) {
        const auto [low, high] = std::minmax({first[i], first[j]});
        std::ranges::replace(first, std::uint32_t{high}, std::uint32_t{low});
      }
  std::vector<std::uint32_t> labels(boxes.size());
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) labels[i] = first[i] == i ? ++count : labels[first[i]];
  return labels;
}

TEST_P(Families, UnionsAreThoseOfBruteForce) {
  const BoxSet few = boxes(18);
  const Array<Vertex> vertices = brute_force_vertices(ordinal_boxes(few, make_axes(few)));
  const MassProperties mass = brute_force_mass(doubles(few));
  for (const RowOrder order : kRowOrders)
    for (const Options& options : {kAutomatic, kCells, kSlices}) {
      const BoxSet rows = boxes(18, order);
      EXPECT_EQ(unite(rows, options).vertices, vertices) << name(order);
      EXPECT_EQ(measure(rows, options), mass) << name(order);
    }
}

TEST_P(Families, ModelsAreDisjointBoxesOfTheSameSolid) {
  const Solid solid = unite(boxes(30), kCells);
  for (const AxisOrder& order : kAxisOrders)
    for (const BoxModel model : {BoxModel::oudb, BoxModel::cudb}) {
      const Evm evm = make_evm(solid, order);
      const Decomposition disjoint = decompose(evm, model);
      EXPECT_EQ(make_evm(disjoint).vertices, evm.vertices) << to_string(order);
      for (std::size_t i = 0; i < disjoint.boxes.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          ASSERT_FALSE(overlap(disjoint.boxes[i], disjoint.boxes[j])) << to_string(order);
    }
}

TEST_P(Families, LabelsAreThoseOfAllPairs) {
  const Solid solid = unite(boxes(30), kCells);
  for (const AxisOrder& order : kAxisOrders) {
    const Decomposition disjoint = decompose(make_evm(solid, order), BoxModel::cudb);
    for (const Connectivity connectivity : {Connectivity::faces, Connectivity::points})
      EXPECT_EQ(label_components(find_neighbors(disjoint, connectivity)).labels,
                brute_force_labels(disjoint.boxes, connectivity))
          << to_string(order);
  }
}

TEST_P(Families, OrderOfRowsAndMethodChangeNoBit) {
  const Solid solid = unite(boxes(400), kSlices);
  const MassProperties mass = measure(boxes(400), kSlices);
  for (const RowOrder order : kRowOrders) {
    const BoxSet rows = boxes(400, order);
    for (const Options& options : {kAutomatic, kCells}) {
      const Solid again = unite(rows, options);
      EXPECT_EQ(again.vertices, solid.vertices) << name(order);
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (const Vertex& v : solid.vertices) {
          const std::uint32_t ordinal = std::array{v.x, v.y, v.z}[axis];
          ASSERT_EQ(again.axes[axis].coordinate(ordinal), solid.axes[axis].coordinate(ordinal));
        }
      EXPECT_EQ(measure(rows, options), mass) << name(order);
    }
  }
}

/// Cells and their items, by boxes and vertices. They are most numerous for deep overlap.
TEST_P(Families, WorkIsLinearInInputAndOutput) {
  for (const std::size_t size : {1500, 6000})
    for (const RowOrder order : kRowOrders) {
      const BoxSet rows = boxes(size, order);
      Report measured, united;
      const MassProperties mass = measure(rows, kCells, &measured);
      unite(rows, kCells, &united);
      for (const CellStatistics& work : {measured.cells, united.cells}) {
        const std::uint64_t steps = work.cells + work.items + work.covered_cells;
        EXPECT_LE(steps, 32 * (rows.size() + mass.vertices)) << size << ' ' << name(order);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(All, Families, testing::ValuesIn(families().begin(), families().end()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace

void PrintTo(const Family& family, std::ostream* out) {
  *out << family.name;
}

}  // namespace boxunion

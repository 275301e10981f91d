// Inputs that are bad for a uniform grid. Small ones must have the vertices that brute force and slices find,
// with every kernel and cell size. Large ones must cause only near-linear work, by the grid's own counters;
// time is never asserted.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "core/base/sample.hpp"
#include "core/cells/tiles.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

constexpr int kUniverse = 1 << 20;

/// Random integers below a bound, the same on every machine.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  int below(int bound) { return int((std::uint64_t{engine_()} * std::uint64_t(bound)) >> 32); }
  double real() { return double((std::uint64_t{engine_()} << 21) ^ engine_()) * 0x1p-53; }

 private:
  std::mt19937 engine_;
};

/// A box with these edges inside [0, kUniverse]^3.
IntegerBox place(Random& random, const std::array<int, 3>& edge) {
  IntegerBox box;
  for (int a = 0; a < 3; ++a) {
    box[a] = random.below(kUniverse - edge[a] + 1);
    box[a + 3] = box[a] + edge[a];
  }
  return box;
}

template <class MakeBox>
BoxSet each(int n, MakeBox&& make_box) {
  Random random(std::uint32_t(n) + 17);
  std::vector<decltype(make_box(random, 0))> boxes;
  for (int i = 0; i < n; ++i) boxes.push_back(make_box(random, i));
  return boxes;
}

/// The edge of cubes that have `density` neighbors each, if n of them lie in `universe`^3.
int edge_for(int n, double density, int universe = kUniverse) {
  return std::max(1, int(universe * std::cbrt(density / n)));
}

/// Nearly all boxes lie in a thousandth of the universe.
BoxSet clustered(int n) {
  const int cluster = kUniverse / 1000, edge = edge_for(n, 0.3, cluster);
  return each(n, [=](Random& random, int i) {
    IntegerBox box = place(random, {edge, edge, edge});
    if (i % 1000 == 7) return box;
    for (int a = 0; a < 3; ++a) {
      box[a] = kUniverse / 3 + random.below(cluster);
      box[a + 3] = box[a] + edge;
    }
    return box;
  });
}

/// Edges from 1e-4 to 1 of the universe. The boxes of each size together fill the universe about once.
BoxSet mixed_sizes(int n) {
  return each(n, [=](Random& random, int) {
    const double size = std::max(1e-4, std::cbrt(1 / (1 + n * random.real())));
    std::array<int, 3> edge;
    for (int& e : edge) e = std::max(1, int(kUniverse * size * (0.5 + 0.5 * random.real())));
    return place(random, edge);
  });
}

BoxSet on_one_plane(int n) {
  const int edge = std::max(1, int(kUniverse / std::sqrt(n)));
  return each(n, [=](Random& random, int) {
    IntegerBox box = place(random, {edge, edge, 1});
    box[2] = 4711, box[5] = 4712;
    return box;
  });
}

/// Rods as long as the universe along `axis`, or along each axis in turn. Each crosses a few others.
BoxSet rods(int n, int axis) {
  const int width = std::max(1, kUniverse / n);
  const int side = std::max(1, int(kUniverse / std::sqrt(n)));
  return each(n, [=](Random& random, int i) {
    std::array<int, 3> edge;
    edge.fill(axis < 3 ? side : width);
    edge[axis < 3 ? axis : i % 3] = kUniverse;
    return place(random, edge);
  });
}

BoxSet plates(int n) {
  const int edge = edge_for(n, 4);
  return each(n, [=](Random& random, int i) {
    std::array<int, 3> edges{edge, edge, edge};
    edges[i % 3] = 1;
    return place(random, edges);
  });
}

BoxSet copies(int n) {
  return each(n, [](Random&, int) { return IntegerBox{-3, 5, 7, 1000, 2000, 4000}; });
}
BoxSet nested(int n) {
  return each(n, [](Random&, int i) { return IntegerBox{0, 0, 0, i + 1, i + 1, i + 1}; });
}
BoxSet concentric(int n) {
  return each(n, [](Random&, int i) { return IntegerBox{-i - 1, -i - 1, -i - 1, i + 1, i + 1, i + 1}; });
}
/// Every box begins and ends at the same z.
BoxSet one_layer(int n) {
  const int edge = std::max(1, int(kUniverse * std::sqrt(0.5 / n)));
  return each(n, [=](Random& random, int) {
    IntegerBox box = place(random, {edge, edge, 1});
    box[2] = 0, box[5] = kUniverse;
    return box;
  });
}
BoxSet staircase(int n) {
  return each(n, [=](Random&, int i) { return IntegerBox{0, 0, 0, i + 1, n - i, i / 2 + 1}; });
}
BoxSet checkerboard(int n) {
  return collect(generate_checkerboard(std::max(1, int(std::cbrt(2.0 * n)))));
}
BoxSet full_grid(int n) {
  const int side = std::max(1, int(std::cbrt(n)));
  return each(side * side * side, [=](Random&, int i) {
    const int x = i % side, y = i / side % side, z = i / side / side;
    return IntegerBox{x, y, z, x + 1, y + 1, z + 1};
  });
}
BoxSet random_doubles(int n) {
  const double edge = std::cbrt(0.5 / n);
  return each(n, [=](Random& random, int) {
    Box box;
    for (int a = 0; a < 3; ++a) {
      box[a] = random.real() - 0.5;
      box[a + 3] = box[a] + edge * (0.5 + random.real());
    }
    return box;
  });
}
/// The whole range of int32.
BoxSet huge_range(int n) {
  return each(n, [=](Random& random, int i) {
    IntegerBox box;
    for (int a = 0; a < 3; ++a) {
      const std::int64_t low = std::int64_t(random.real() * 0x1p32) - (std::int64_t{1} << 31);
      const std::int64_t high = low + 1 + std::int64_t(0x1p32 * random.real() * std::cbrt(0.5 / n));
      box[a] = i == 0 ? -2147483647 : int(low);
      box[a + 3] = i == 0 ? -2147483647 + 9 : int(std::min<std::int64_t>(high, 2147483646));
      if (i == 1) box[a] = 2147483600, box[a + 3] = 2147483646;
    }
    return box;
  });
}
/// Faces on, just before and just after the borders of a grid of powers of two.
BoxSet powers_of_two(int n) {
  return each(n, [=](Random& random, int) {
    IntegerBox box;
    for (int a = 0; a < 3; ++a) {
      const int step = 1 << (3 + random.below(12)), cells = std::max(1, (1 << 15) / step);
      box[a] = step * random.below(cells) + random.below(3) - 1;
      box[a + 3] = std::max(box[a] + 1, box[a] + step * (1 + random.below(2)) + random.below(3) - 1);
    }
    return box;
  });
}

struct Unlucky {
  const char* name;
  BoxSet (*make)(int n);
  double work;          ///< bound of cells + items: this times n * log2(n) ...
  double exponent = 1;  ///< ... times n^(exponent - 1)
};

void PrintTo(const Unlucky& unlucky, std::ostream* out) {
  *out << unlucky.name;
}

const Unlucky kUnlucky[] = {
    {"clustered", clustered, 2},
    {"mixed_sizes", mixed_sizes, 2},
    {"on_one_plane", on_one_plane, 2},
    {"rods_along_x", [](int n) { return rods(n, 0); }, 2},
    {"rods_along_y", [](int n) { return rods(n, 1); }, 2},
    {"rods_along_z", [](int n) { return rods(n, 2); }, 2},
    // no way to divide space does better (Paterson and Yao, 1992)
    {"rods_along_all", [](int n) { return rods(n, 3); }, 0.1, 1.5},
    {"plates", plates, 2},
    {"copies", copies, 2},
    {"nested", nested, 2},
    {"concentric", concentric, 2},
    {"one_layer", one_layer, 2},
    {"staircase", staircase, 30},
    {"checkerboard", checkerboard, 2},
    {"full_grid", full_grid, 2},
    {"random_doubles", random_doubles, 2},
    {"huge_range", huge_range, 2},
    {"powers_of_two", powers_of_two, 2},
};

class UnluckyInput : public testing::TestWithParam<Unlucky> {};

TEST_P(UnluckyInput, OfAFewBoxesEqualsBruteForce) {
  for (const int n : {1, 2, 5, 12}) {
    const BoxSet set = GetParam().make(n);
    const Array<Vertex> expected = brute_force_vertices(ordinal_boxes(set, make_axes(set)));
    for (const CellKernel kernel : {CellKernel::occupancy, CellKernel::faces})
      for (const std::uint32_t cell : {0u, 1u, 8u, 1u << 19})
        ASSERT_EQ(unite(set, {.kernel = kernel, .device = "native", .tuning = {.cell = cell}}).vertices,
                  expected)
            << n << " boxes, kernel " << int(kernel) << ", cell " << cell;
    ASSERT_EQ(unite(set, {.method = Method::slices, .device = "native"}).vertices, expected) << n << " boxes";
  }
}

TEST_P(UnluckyInput, HasTheVerticesOfSlicesOnEveryDevice) {
  const BoxSet set = GetParam().make(300);
  const Array<Vertex> expected = unite(set, {.method = Method::slices, .device = "native"}).vertices;
  for (const CellKernel kernel : {CellKernel::occupancy, CellKernel::faces}) {
    for (const std::uint32_t cell : {0u, 1u, 8u, 1u << 19})
      ASSERT_EQ(unite(set, {.kernel = kernel, .device = "native", .tuning = {.cell = cell}}).vertices,
                expected)
          << "kernel " << int(kernel) << ", cell " << cell;
    for (const DeviceInfo& device : list_devices())
      ASSERT_EQ(unite(set, {.kernel = kernel, .device = device.id}).vertices, expected)
          << "kernel " << int(kernel) << ", device " << device.id;
  }
}

TEST_P(UnluckyInput, CostsNearLinearWork) {
  const Unlucky& unlucky = GetParam();
  for (const int n : {3000, 30000}) {
    const BoxSet set = unlucky.make(n);
    Report report;
    const MassProperties mass = measure(set, {.method = Method::cells, .device = "native"}, &report);
    const double work = double(report.cells.cells + report.cells.items);
    const double bound = unlucky.work * std::pow(n, unlucky.exponent) * std::log2(n);
    EXPECT_LE(work, bound) << n << " boxes, " << mass.vertices << " vertices";
    // a run on vertices must agree with the sums that a run on a lattice may use
    EXPECT_EQ(measure(set, {.kernel = CellKernel::faces, .device = "native", .statistics = true}), mass);
  }
}

INSTANTIATE_TEST_SUITE_P(Inputs, UnluckyInput, testing::ValuesIn(kUnlucky),
                         [](const testing::TestParamInfo<Unlucky>& info) { return info.param.name; });

/// Known values of unions in which many boxes are hidden.
TEST(UnluckyUnion, OfManyHiddenBoxesIsTheOuterBox) {
  constexpr int n = 50000;
  const auto check = [](const BoxSet& set, double edge_sum, double volume) {
    const MassProperties mass = measure(set, {.device = "native"});
    EXPECT_EQ(mass.vertices, 8u);
    EXPECT_EQ(mass.edge_length, edge_sum);
    EXPECT_EQ(mass.volume, volume);
  };
  check(copies(n), 4.0 * (1003 + 1995 + 3993), 1003.0 * 1995 * 3993);
  check(nested(n), 12.0 * n, std::pow(n, 3));
  check(concentric(n), 24.0 * n, 8 * std::pow(n, 3));
}

/// The few boxes of one operand touch far more tiles than the average over all operands. The plan is right
/// nevertheless.
TEST(UnluckyInput, OperandsOfUnlikeBoxesShareAPlan) {
  const BoxSet cubes = collect(generate_cubes(200'000, 20, 1 << 15, 3));
  std::vector<IntegerBox> plates;
  for (int i = 0; i < 3000; ++i) plates.push_back({0, 0, 10 * i, 1 << 15, 1 << 15, 10 * i + 1});
  const BoxSet sets[] = {cubes, plates};
  const auto volume = [&](const char* text) {
    return measure(Expression::parse(text), sets, {.device = "native"}).volume;
  };
  EXPECT_EQ(volume("A and B") + volume("A not B"), measure(cubes, {.device = "native"}).volume);
}

/// A few boxes that a small sample misses would be in every tile, so the tiles are planned again.
TEST(UnluckyInput, TilesArePlannedAgainWhereASampleMissesTheLongBoxes) {
  const std::vector<IntegerBox> cubes = collect(generate_cubes(400'000, 20, 1 << 15, 3));
  std::vector<IntegerBox> boxes = cubes;
  constexpr std::uint64_t kStep = 5;  // long boxes at positions that the first sample skips
  std::vector<bool> seen(boxes.size());
  Sample(boxes.size(), TileGrid::kSample).each([&](std::uint64_t i) { seen[i] = true; });
  for (std::size_t i = 0; i < boxes.size(); i += kStep)
    if (!seen[i]) boxes[i] = {0, 0, boxes[i][2], 1 << 15, 1 << 15, boxes[i][2] + 1};
  const std::array counts{1u << 15, 1u << 15, 1u << 15};
  std::vector<OrdinalBox> ordinals;
  for (const IntegerBox& b : boxes) {
    const auto at = [&](unsigned c) { return std::uint32_t(b[c]) + 1; };
    ordinals.push_back({{at(0), at(1), at(2)}, {at(3), at(4), at(5)}});
  }
  const std::vector<OrdinalSource> source{OrdinalSource(ordinals)};
  const TileGrid::Plan first = TileGrid::plan(source, counts, 13, 250);
  EXPECT_TRUE(TileGrid(source[0], first).misjudged());
  const TileGrid::Plan again = TileGrid::plan(source, counts, 13, 250, 16 * TileGrid::kSample);
  EXPECT_FALSE(TileGrid(source[0], again).misjudged());
  // statistics need the vertices
  EXPECT_EQ(measure(boxes, {.device = "native"}), measure(boxes, {.device = "native", .statistics = true}));
}

}  // namespace
}  // namespace boxunion

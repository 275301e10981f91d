// Boxes that share a corner: the sweep gives the same results as cells, to the last bit.

#include "core/anchored/anchored.hpp"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "core/anchored/staircase.hpp"
#include "core/solid/solid_sink.hpp"
#include "tests/engine/ways.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

const Options kSwept{.device = "native"}, kCells{.method = Method::cells, .device = "native"};

bool same_axes(const Axes& a, const Axes& b) {
  for (unsigned axis = 0; axis < 3; ++axis) {
    if (a[axis].count() != b[axis].count() || a[axis].is_lattice() != b[axis].is_lattice()) return false;
    for (std::uint32_t i = 1; i <= std::min(a[axis].count(), 1000u); ++i)
      if (a[axis].coordinate(i) != b[axis].coordinate(i)) return false;
  }
  return true;
}

/// Checks that the sweep is chosen and gives the same results as cells.
void expect_same(const BoxSet& boxes) {
  Report report;
  const MassProperties mass = measure(boxes, kSwept, &report);
  ASSERT_EQ(report.method, "staircase");
  ASSERT_EQ(mass, measure(boxes, kCells));
  const Solid solid = unite(boxes, kSwept, &report), expected = unite(boxes, kCells);
  ASSERT_EQ(report.method, "staircase");
  ASSERT_EQ(solid.vertices, expected.vertices);
  ASSERT_TRUE(same_axes(solid.axes, expected.axes));
  MassSink sink(solid.axes);
  sink.add(solid.vertices);
  ASSERT_EQ(sink.result(), mass);
}

/// Boxes with reaches `reaches` from the corner `at`. `corner` says on which axes they reach downwards.
std::vector<Box> boxes_at(const std::array<double, 3>& at, const CommonCorner& corner,
                          std::span<const std::array<double, 3>> reaches) {
  std::vector<Box> boxes;
  for (const auto& reach : reaches) {
    Box box;
    for (unsigned a = 0; a < 3; ++a) {
      box[a] = corner[a] ? at[a] - reach[a] : at[a];
      box[a + 3] = corner[a] ? at[a] : at[a] + reach[a];
    }
    boxes.push_back(box);
  }
  return boxes;
}

CommonCorner corner_of(unsigned bits) {
  return {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
}

BoxSet integers(std::span<const Box> boxes) {
  std::vector<IntegerBox> result;
  for (const Box& box : boxes) {
    IntegerBox& to = result.emplace_back();
    for (unsigned k = 0; k < 6; ++k) to[k] = int(box[k]);
  }
  return result;
}

TEST(Anchored, EveryPairOfSmallBoxesAtEveryCorner) {
  for (unsigned bits = 0; bits < 8; ++bits)
    for (unsigned pair = 0; pair < 27 * 27; ++pair) {
      std::array<std::array<double, 3>, 2> reaches;
      for (unsigned i = 0, rest = pair; i < 6; ++i, rest /= 3) reaches[i / 3][i % 3] = rest % 3;
      const std::vector<Box> boxes = boxes_at({5, -1, 0}, corner_of(bits), reaches);
      ASSERT_EQ(measure(boxes, kSwept), brute_force_mass(boxes)) << bits << ' ' << pair;
      const Solid solid = unite(boxes, kSwept);
      ASSERT_EQ(solid.vertices, brute_force_vertices(ordinal_boxes(boxes, solid.axes)))
          << bits << ' ' << pair;
    }
}

/// All sets of boxes with low corners on a small grid: every antichain, and many sets with dominated boxes.
TEST(Anchored, EverySetOfCornersOfASmallGrid) {
  for (unsigned set = 1; set < 256; ++set)
    for (const unsigned bits : {0u, 3u, 6u, 7u}) {
      std::vector<std::array<double, 3>> reaches;
      for (unsigned i = 0; i < 8; ++i)
        if (set >> i & 1)
          reaches.push_back({double(1 + (i & 1)), double(1 + (i >> 1 & 1)), double(1 + (i >> 2))});
      expect_same(boxes_at({0, 0, 0}, corner_of(bits), reaches));
      if (HasFatalFailure()) FAIL() << set << ' ' << bits;
    }
}

TEST(Anchored, RandomSetsWithTiesAgreeWithCellsAndBruteForce) {
  std::mt19937_64 random(1);
  const auto below = [&](unsigned n) { return unsigned(random() % n); };
  for (int round = 0; round < 3000; ++round) {
    const unsigned count = 1 + below(12), range = 2 + below(7);
    const double scale = std::array{1.0, 0.1, 1e-9, 0x1p-30, 1e200}[below(5)];
    const double offset = std::array{0.0, -0.0, 1.0, -7.3}[below(4)];
    std::vector<std::array<double, 3>> reaches;
    for (unsigned i = 0; i < count; ++i)
      reaches.push_back({scale * below(range), scale * below(range), scale * (1 + below(range))});
    const std::vector<Box> boxes = boxes_at({offset, offset, offset}, corner_of(below(8)), reaches);
    expect_same(boxes);
    if (HasFatalFailure()) FAIL() << round;
    if (round % 8 == 0) {
      ASSERT_EQ(measure(boxes, kSwept), brute_force_mass(boxes)) << round;
      const Solid solid = unite(boxes, kSwept);
      ASSERT_EQ(solid.vertices, brute_force_vertices(ordinal_boxes(boxes, solid.axes))) << round;
    }
    if (scale == 1 && offset != -7.3) expect_same(integers(boxes));
    if (HasFatalFailure()) FAIL() << round;
  }
}

/// A front of points on the simplex, except for rounding.
std::vector<Box> front(std::size_t count, std::uint64_t seed, double least = 0) {
  std::mt19937_64 random(seed);
  std::exponential_distribution<double> exponential;
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<double, 3> x{exponential(random), exponential(random), exponential(random)};
    const double sum = x[0] + x[1] + x[2];
    boxes.push_back(
        {least + x[0] / sum, least + x[1] / sum, least + x[2] / sum, least + 1, least + 1, least + 1});
  }
  return boxes;
}

TEST(Anchored, FrontsOfDoubles) {
  for (const std::size_t count : {100u, 1000u, 5000u}) {
    expect_same(front(count, count));
    expect_same(front(count, count, 0.1));
    expect_same(front(count, count, -3));
  }
}

/// Numbers of every width that the sums distinguish, and numbers that no integer sum can hold.
TEST(Anchored, CoordinatesOfManyMagnitudes) {
  std::mt19937_64 random(7);
  for (const int magnitudes : {1, 8, 11, 12, 25, 28, 40, 60, 72, 74, 75, 76, 100, 900}) {
    std::vector<Box> boxes;
    for (int i = 0; i < 300; ++i) {
      Box box{0, 0, 0, 1, 1, 1};
      for (unsigned a = 0; a < 3; ++a) {
        const double digits = 0.5 + std::ldexp(double(random() >> 12), -53);
        box[a] = std::ldexp(digits, -int(random() % unsigned(magnitudes)));
      }
      boxes.push_back(box);
    }
    const bool narrow = magnitudes <= 72;
    EXPECT_TRUE(!narrow || sum_anchored(boxes, {true, true, true}).has_value()) << magnitudes;
    EXPECT_TRUE(magnitudes < 100 || !sum_anchored(boxes, {true, true, true})) << magnitudes;
    Report report;
    EXPECT_EQ(measure(boxes, kSwept, &report), measure(boxes, kCells)) << magnitudes;
    EXPECT_EQ(report.method, "staircase");
    EXPECT_EQ(unite(boxes, kSwept).vertices, unite(boxes, kCells).vertices) << magnitudes;
  }
}

TEST(Anchored, CoordinatesAtTheLimitsOfDouble) {
  const double most = std::numeric_limits<double>::max(), least = std::numeric_limits<double>::denorm_min();
  for (const std::vector<double>& numbers :
       {std::vector{most, most / 2, most / 3}, std::vector{least, 2 * least, 1000 * least},
        std::vector{least, 1e-310, 1e-300}, std::vector{1.0, 1e300, most}, std::vector{0.0, least, most}}) {
    std::vector<std::array<double, 3>> reaches;
    for (const double x : numbers)
      for (const double y : numbers) reaches.push_back({x, y, std::abs(numbers[2] - x / 2)});
    for (unsigned bits = 0; bits < 8; ++bits) expect_same(boxes_at({0, 0, 0}, corner_of(bits), reaches));
  }
}

TEST(Anchored, PartsOfTheSweepAddUpToTheWhole) {
  std::vector<Box> boxes = front(6000, 3);
  for (Box& box : boxes) box[2] = std::round(box[2] * 50) / 50;  // parts of the sweep end between planes
  const MassProperties mass = measure(boxes, kCells);
  const Solid solid = unite(boxes, kCells);
  for (const int threads : {1, 2, 3, 7}) {
    const MassProperties found = tbb::task_arena(threads).execute([&] {
      return sum_anchored(boxes, {true, true, true})->result();
    });
    EXPECT_EQ(found, mass) << threads;
    SolidSink sink(solid.axes);
    const Ordinals ordinals = make_ordinals(boxes);
    tbb::task_arena(threads).execute([&] { unite_anchored(ordinals.boxes, {true, true, true}, sink); });
    EXPECT_EQ(sink.take().vertices, solid.vertices) << threads;
  }
}

TEST(Anchored, MeshesAreThoseOfCells) {
  const std::vector<Box> boxes = front(300, 9);
  const Mesh mesh = make_mesh(unite(boxes, kSwept), NonManifold::split);
  const Mesh expected = make_mesh(unite(boxes, kCells), NonManifold::split);
  EXPECT_EQ(mesh.points, expected.points);
  EXPECT_EQ(mesh.triangles, expected.triangles);
}

TEST(Anchored, OnlyBoxesThatShareACornerAreSwept) {
  const auto method = [](const BoxSet& boxes, Options options = kSwept) {
    Report report;
    measure(boxes, options, &report);
    return report.method;
  };
  std::vector<Box> boxes = front(200, 5);
  EXPECT_EQ(method(boxes), "staircase");
  EXPECT_EQ(method(boxes, kCells), "cells");
  EXPECT_EQ(method(boxes, {.method = Method::slices, .device = "native"}), "slices");
  EXPECT_EQ(method(boxes, {.kernel = CellKernel::faces, .device = "native"}), "cells");
  EXPECT_EQ(method(boxes, {.device = "native", .statistics = true}), "cells");
  EXPECT_EQ(method(BoxSet()), "cells");
  for (const std::size_t odd : {0u, 1u, 63u, 64u, 199u}) {
    std::vector<Box> others = boxes;
    others[odd][4] = 0.99999;
    EXPECT_EQ(find_common_corner(others), std::nullopt);
    EXPECT_EQ(method(others), "cells");
  }
  // the corner may be low on one axis and high on another
  EXPECT_EQ(find_common_corner(std::vector<Box>{{0, 0, 0, 1, 2, 3}, {0, 1, 0, 5, 2, 9}}),
            (CommonCorner{false, true, false}));
}

TEST(Anchored, InterruptedSweepsEnd) {
  const std::atomic<bool> interrupted = true;
  Options options = kSwept;
  options.interrupted = &interrupted;
  const auto kind = [](auto&& f) {
    try {
      f();
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::usage;
  };
  const std::vector<Box> boxes = front(3000, 5);
  EXPECT_EQ(kind([&] { measure(boxes, options); }), ErrorKind::interrupted);
  EXPECT_EQ(kind([&] { unite(boxes, options); }), ErrorKind::interrupted);
}

// ---- work ----

struct CountingVisitor {
  std::size_t columns = 0, planes = 0;
  void column(const StairColumn&) { ++columns; }
  void plane(std::uint64_t) { ++planes; }
};

std::size_t columns_of(std::vector<AnchoredBox> reaches) {
  const StairSweep sweep(Array<AnchoredBox>(reaches.begin(), reaches.end()));
  std::vector<CountingVisitor> visitor(1);
  sweep.sweep(std::span(visitor));
  EXPECT_LE(visitor[0].planes, reaches.size() + 1);
  return visitor[0].columns;
}

/// A box makes up to two columns, and up to one more for each corner that it hides.
TEST(Anchored, TheWorkIsLinearInTheBoxes) {
  std::mt19937_64 random(3);
  const std::uint64_t n = 20'000;
  std::vector<AnchoredBox> nested, flat, stairs, tall, mixed, plane;
  for (std::uint64_t i = 1; i <= n; ++i) {
    nested.push_back({i, i, i});
    flat.push_back({i, n + 1 - i, 5});
    stairs.push_back({i, n + 1 - i, i});
    tall.push_back({i, i, n + 1 - i});
    mixed.push_back({random() % n + 1, random() % n + 1, random() % n + 1});
    plane.push_back({random() % 100 + 1, random() % 100 + 1, 1});
  }
  for (const auto& reaches : {nested, flat, stairs, tall, mixed, plane})
    EXPECT_LE(columns_of(reaches), 5 * n);
}

}  // namespace
}  // namespace boxunion

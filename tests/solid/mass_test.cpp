#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/parallel.hpp"
#include "core/solid/mass_sink.hpp"
#include "tests/support/generators.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

MassProperties measure(const BoxSet& boxes, const Axes& axes) {
  MassSink sink(axes);
  sink.add(brute_force_vertices(ordinal_boxes(boxes, axes)));
  return sink.result();
}

void check_against_rationals(const std::vector<Box>& boxes) {
  const MassProperties expected = brute_force_mass(boxes);
  RC_ASSERT(measure(boxes, make_axes(boxes)) == expected);
  RC_ASSERT(measure(boxes, make_rank_axes(boxes)) == expected);
}

RC_GTEST_PROP(Mass, SmallIntegersAreRoundedOnce, ()) {
  check_against_rationals(*boxes_from(small_integer()));
}
RC_GTEST_PROP(Mass, DecimalsAreRoundedOnce, ()) {
  check_against_rationals(*boxes_from(decimal()));
}
RC_GTEST_PROP(Mass, NastyCoordinatesAreRoundedOnce, ()) {
  check_against_rationals(*boxes_from(nasty_coordinate()));
}
RC_GTEST_PROP(Mass, AnyDoublesAreRoundedOnce, ()) {
  const auto finite = rc::gen::map(rc::gen::arbitrary<std::uint64_t>(), [](std::uint64_t bits) {
    const double x = std::bit_cast<double>(bits);
    return std::isfinite(x) ? x : 1.0;
  });
  check_against_rationals(*boxes_from(finite));
}
RC_GTEST_PROP(Mass, RanksOfEveryExponentInAWindowAreRoundedOnce, ()) {
  const int low = *rc::gen::element(-1074, -1030, -8, 0, 950);
  const auto coordinate =
      rc::gen::map(rc::gen::pair(rc::gen::arbitrary<std::int64_t>(), rc::gen::inRange(0, 20)),
                   [low](const std::pair<std::int64_t, int>& x) {
                     return std::ldexp(double(x.first >> 11), low + x.second);
                   });
  check_against_rationals(*boxes_from(coordinate));
}
RC_GTEST_PROP(Mass, OneLatticeBesideRanksIsRoundedOnce, ()) {
  const auto integers = *boxes_from(small_integer());
  auto boxes = *boxes_from(nasty_coordinate());
  boxes.resize(std::min(boxes.size(), integers.size()));
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    boxes[i][1] = integers[i][1];
    boxes[i][4] = integers[i][4];
  }
  check_against_rationals(boxes);
}
RC_GTEST_PROP(Mass, WideLatticesAreRoundedOnce, ()) {
  const double offset = *rc::gen::element(0.0, 0x1p52, -0x1p53, -1e9);
  const double step = *rc::gen::element(1.0, 0x1p-30, 0x1p200, 0x1p-200);
  const auto coordinate = rc::gen::map(rc::gen::arbitrary<std::uint32_t>(), [=](std::uint32_t i) {
    return (offset + std::min(i, 0xfffffffdu)) * step;
  });
  check_against_rationals(*boxes_from(coordinate));
}

TEST(Mass, WidestLatticeIsRoundedOnce) {
  const double top = 4294967293.0;
  const std::vector<Box> boxes = {{0, 0, 0, top, top, top}};
  const Axes axes = make_axes(boxes);
  ASSERT_EQ(axes[0].count(), 0xfffffffeu);
  EXPECT_EQ(measure(boxes, axes), brute_force_mass(boxes));
}

TEST(Mass, EveryMaskHasItsVolumeAreaAndLength) {
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::vector<Box> boxes = {{1, 1, 1, 1, 3, 3}};  // a degenerate box, so that the grid is always the same
    for (int octant = 0; octant < 8; ++octant) {
      const double x = 1 + (octant & 1), y = 1 + (octant >> 1 & 1), z = 1 + (octant >> 2);
      if (mask >> octant & 1u) boxes.push_back({x, y, z, x + 1, y + 1, z + 1});
    }
    EXPECT_EQ(measure(boxes, make_axes(boxes)), brute_force_mass(boxes)) << "mask " << mask;
  }
}

TEST(Mass, UnitCube) {
  const std::vector<Box> boxes = {{0, 0, 0, 1, 1, 1}};
  const MassProperties p = measure(boxes, make_axes(boxes));
  EXPECT_EQ(p.volume, 1);
  EXPECT_EQ(p.area, 6);
  EXPECT_EQ(p.edge_length, 12);
  EXPECT_EQ(p.vertices, 8u);
  EXPECT_EQ(p.centroid, (std::array{0.5, 0.5, 0.5}));
  EXPECT_EQ(p.inertia[0], (std::array{1 / 6., 0., 0.}));
}

TEST(Mass, NothingIsAllZeros) {
  EXPECT_EQ(MassSink(Axes{}).result(), MassProperties{});
}

TEST(Mass, ValuesBeyondDoubleAreInfinite) {
  const std::vector<Box> boxes = {{0, 0, 0, 1e300, 1e300, 1e300}};
  const MassProperties p = measure(boxes, make_axes(boxes));
  EXPECT_EQ(p.volume, std::numeric_limits<double>::infinity());
  EXPECT_EQ(p.centroid[0], 0.5e300);
}

/// A few thousand vertices with every mask at random places. No union has them, but their sums are defined.
Array<Vertex> random_vertices(const Axes& axes, std::size_t count) {
  std::mt19937_64 random(7);
  Array<Vertex> vertices(count);
  const auto ordinal = [&](int axis) {
    return std::uint32_t(1 + random() % axes[std::size_t(axis)].count());
  };
  for (Vertex& v : vertices) v = {ordinal(0), ordinal(1), ordinal(2), std::uint32_t(random() % 256)};
  return vertices;
}

std::vector<Axes> kinds_of_axes() {
  const Axis small = Axis::lattice(-7, -3, 1000), wide = Axis::lattice(12, 5, 0xfffffffeu);
  const Axis rank = Axis::rank({-1e300, -1, -1e-300, 0, 5e-324, 0.1, 3, 1e22});
  return {{small, small, small}, {wide, wide, wide}, {rank, rank, rank}, {small, rank, wide}};
}

TEST(Mass, OrderBatchesAndThreadsDoNotMatter) {
  for (const Axes& axes : kinds_of_axes()) {
    Array<Vertex> vertices = random_vertices(axes, 5000);
    MassSink at_once(axes);
    at_once.add(vertices);
    for (const int threads : {1, 2, 5}) {
      std::shuffle(vertices.begin(), vertices.end(), std::mt19937(unsigned(threads)));
      MassSink in_batches(axes);
      tbb::task_arena(threads).execute([&] {
        parallel_ranges(0, vertices.size(), 10, [&](std::size_t begin, std::size_t end) {
          in_batches.add(std::span(vertices).subspan(begin, end - begin));
        });
      });
      EXPECT_EQ(in_batches.result(), at_once.result()) << threads << " threads";
    }
  }
}

TEST(Mass, LatticeAndRankSumsOfMillionsOfVerticesAgree) {
  for (const std::uint32_t step : {100u, 500'000'000u}) {  // narrow and wide lattices
    std::vector<double> coordinates;
    for (std::uint32_t i = 0; i < 8; ++i) coordinates.push_back(1 + i * double(step));
    const Axis rank = Axis::rank(coordinates), lattice = Axis::lattice(0, 0, 1 + 7 * step);
    Array<Vertex> vertices = random_vertices({rank, rank, rank}, 3'000'000);
    MassSink by_rank({rank, rank, rank});
    by_rank.add(vertices);
    for (Vertex& v : vertices) v = {1 + (v.x - 1) * step, 1 + (v.y - 1) * step, 1 + (v.z - 1) * step, v.mask};
    MassSink by_lattice({lattice, lattice, lattice});
    by_lattice.add(vertices);
    EXPECT_EQ(by_lattice.result(), by_rank.result());
  }
}

/// The sums over the part of the union inside one region, relative to its low corner and modulo 2^64, without
/// area and length.
LatticeSums region_sums(std::vector<OrdinalBox> boxes, const OrdinalBox& region) {
  std::erase_if(boxes, [&](OrdinalBox& box) {
    bool empty = false;
    for (unsigned a = 0; a < 3; ++a) {
      box.lo[a] = std::max(box.lo[a], region.lo[a]);
      box.hi[a] = std::min(box.hi[a], region.hi[a]);
      empty |= box.lo[a] >= box.hi[a];
    }
    return empty;
  });
  LatticeSums sums;
  for (const Vertex& v : brute_force_vertices(boxes)) {
    const std::array<std::uint64_t, 3> x = {v.x - region.lo[0], v.y - region.lo[1], v.z - region.lo[2]};
    const std::uint64_t volume = static_cast<std::uint64_t>(kOctants[v.mask].volume) * x[0] * x[1] * x[2];
    const auto add = [](std::int64_t& to, std::uint64_t term) {
      detail::add_wrapping(to, static_cast<std::int64_t>(term));
    };
    add(sums.volume, volume);
    for (unsigned a = 0; a < 3; ++a) {
      add(sums.first[a], volume * x[a]);
      add(sums.second[a], volume * x[a] * x[a]);
      add(sums.second[3 + a], volume * x[a] * x[(a + 1) % 3]);
    }
  }
  return sums;
}

/// Makes a region own all vertices, faces and edges.
void own_boundary(LatticeSums& sums, std::span<const Vertex> vertices) {
  for (const Vertex& v : vertices) {
    const OctantProperties& weights = kOctants[v.mask];
    const std::array<std::int64_t, 3> x = {v.x, v.y, v.z};
    ++sums.vertices;
    sums.extreme += weights.extreme;
    for (unsigned a = 0; a < 3; ++a) {
      sums.area[a] += weights.area[a] * x[(a + 1) % 3] * x[(a + 2) % 3];
      sums.length[a] += weights.length[a] * x[a];
    }
  }
}

RC_GTEST_PROP(Mass, SumsOfRegionsAreTheSumsOfTheWhole, ()) {
  const bool wide = *rc::gen::arbitrary<bool>();
  std::vector<Box> boxes = *boxes_from(small_integer());
  const double far = wide ? 1 << 22 : 5;
  boxes.push_back({-4, far, -4, -3, far + 1, -3});
  const Axes axes = make_axes(boxes);
  const std::vector<OrdinalBox> ordinals = ordinal_boxes(boxes, axes);
  const Array<Vertex> vertices = brute_force_vertices(ordinals);
  MassSink whole(axes), parts(axes);
  whole.add(vertices);

  // Eight regions that meet at one point. The sums of a long region would not fit.
  std::array<std::uint32_t, 3> middle;
  for (auto& m : middle) m = *rc::gen::inRange<std::uint32_t>(2, 9);
  if (wide) middle[1] = axes[1].count() - 1;
  for (unsigned octant = 0; octant < 8; ++octant) {
    OrdinalBox region;
    for (unsigned a = 0; a < 3; ++a) {
      region.lo[a] = octant >> a & 1u ? middle[a] : 1;
      region.hi[a] = octant >> a & 1u ? std::max(middle[a], axes[a].count()) : middle[a];
    }
    LatticeSums sums = region_sums(ordinals, region);
    if (octant == 0) own_boundary(sums, vertices);
    parts.add(sums, region.lo);
  }
  for (const OrdinalBox& box : ordinals) parts.extend_bounds(box);
  RC_ASSERT(parts.result() == whole.result());
}

/// Second moments that exceed 2^63, and a full region, whose moments about its centre are the largest.
RC_GTEST_PROP(Mass, SumsOfTheLargestRegionsAreExact, ()) {
  constexpr std::uint32_t edge = LatticeSums::kMostEdge;
  const auto end = rc::gen::element(0u, 1u, edge / 2, edge - 1, edge);
  std::vector<OrdinalBox> boxes(*rc::gen::inRange<std::size_t>(1, 5));
  for (OrdinalBox& box : boxes)
    for (unsigned a = 0; a < 3; ++a) {
      const std::uint32_t p = *end, q = *rc::gen::distinctFrom(end, p);
      box.lo[a] = 1 + std::min(p, q), box.hi[a] = 1 + std::max(p, q);
    }
  LatticeSums sums = region_sums(boxes, {{1, 1, 1}, {edge + 1, edge + 1, edge + 1}});
  Array<Vertex> vertices = brute_force_vertices(boxes);
  own_boundary(sums, vertices);
  const std::uint32_t far = *rc::gen::element(0u, 1000u, (1u << 20) - 2 * edge, 1u << 30);
  const Axis axis = Axis::lattice(0, 0, far + edge + 1);
  MassSink whole({axis, axis, axis}), parts({axis, axis, axis});
  parts.add(sums, {1 + far, 1 + far, 1 + far});
  for (Vertex& v : vertices) {
    v.x += far, v.y += far, v.z += far;
    parts.extend_bounds({{v.x, v.y, v.z}, {v.x, v.y, v.z}});
  }
  whole.add(vertices);
  RC_ASSERT(parts.result() == whole.result());
}

TEST(Mass, SumsOfRegionsNeedLattices) {
  MassSink sink({Axis::rank({0, 0.1}), Axis::lattice(0, 0, 2), Axis::lattice(0, 0, 2)});
  EXPECT_THROW(sink.add(LatticeSums{}, {1, 1, 1}), Error);
}

}  // namespace
}  // namespace boxunion

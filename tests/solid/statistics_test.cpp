#include "core/solid/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "boxunion/union.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

/// The sums in rational arithmetic.
BoxSums reference_sums(const BoxSet& boxes) {
  mpq_class volume = 0, area = 0, length = 0;
  std::uint64_t vertices = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box b = boxes[i];
    std::array<mpq_class, 3> edge;
    for (int a = 0; a < 3; ++a) edge[a] = mpq_class(b[a + 3]) - mpq_class(b[a]);
    if (edge[0] == 0 || edge[1] == 0 || edge[2] == 0) continue;
    volume += edge[0] * edge[1] * edge[2];
    area += 2 * (edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0]);
    length += 4 * (edge[0] + edge[1] + edge[2]);
    vertices += 8;
  }
  return {round_to_nearest(volume), round_to_nearest(area), round_to_nearest(length), vertices};
}

VertexKinds kinds_of(const std::vector<IntegerBox>& boxes, Method method = Method::cells) {
  Report report;
  measure(BoxSet(boxes), {.method = method, .device = "native", .statistics = true}, &report);
  return report.statistics->vertices;
}

TEST(BoxSums, OfIntegersAreExact) {
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  std::vector<IntegerBox> boxes = {{kLeast, kLeast, kLeast, kMost, kMost, kMost}, {0, 0, 0, 9, 9, 0}};
  std::mt19937 random(5);
  for (int i = 0; i < 70000; ++i) {
    IntegerBox b;
    for (int a = 0; a < 3; ++a) b[a] = int(random() % 1000), b[a + 3] = b[a] + int(random() % 50);
    boxes.push_back(b);
  }
  EXPECT_EQ(sum_boxes(boxes), reference_sums(boxes));
  EXPECT_EQ(sum_boxes(BoxSet()), BoxSums());
}

TEST(BoxSums, OfDoublesAreExactWhateverTheirExponents) {
  std::mt19937_64 random(6);
  const auto real = [&](int spread) {
    const double unit = double(random() >> 11) * 0x1p-53 - 0.5;
    return std::ldexp(unit, int(random() % unsigned(2 * spread + 1)) - spread);
  };
  for (const int spread : {0, 3, 60, 300}) {
    std::vector<Box> boxes;
    for (int i = 0; i < 2000; ++i) {
      Box b;
      for (int a = 0; a < 3; ++a) {
        const double p = real(spread), q = real(spread);
        b[a] = std::min(p, q), b[a + 3] = std::max(p, q);
      }
      boxes.push_back(b);
    }
    EXPECT_EQ(sum_boxes(boxes), reference_sums(boxes)) << "spread " << spread;
  }
  constexpr double kMost = std::numeric_limits<double>::max();
  constexpr double kLeast = std::numeric_limits<double>::denorm_min();
  const std::vector<Box> extreme = {{-kMost, 0, 0, kMost, kLeast, kLeast},
                                    {-kLeast, -1, -1, kMost, 1e-300, 1}};
  EXPECT_EQ(sum_boxes(extreme), reference_sums(extreme));
}

TEST(VertexKinds, AreThoseOfUnion3InGeneralPosition) {
  for (const Method method : {Method::cells, Method::slices}) {
    EXPECT_EQ(kinds_of({{0, 0, 0, 5, 5, 5}}, method), (VertexKinds{.visible_input = 8}));
    // each has a corner inside the other: 7 corners of each, and 3 edges of each through faces of the other
    EXPECT_EQ(kinds_of({{0, 0, 0, 5, 5, 5}, {2, 3, 4, 8, 9, 10}}, method),
              (VertexKinds{.visible_input = 14, .edge_face = 6}));
    // three boxes, each of which fills a half-space around the origin: 7 of its octants
    EXPECT_EQ(
        kinds_of({{-9, -9, -9, 0, 6, 5}, {-9, -9, -9, 5, 0, 6}, {-9, -9, -9, 6, 5, 0}}, method).three_face,
        1u);
  }
}

TEST(VertexKinds, GoByTheMaskWhereFacesShareAPlane) {
  // copies count once; a cube on a plate looks like edges through the plate; an L has concave corners
  EXPECT_EQ(kinds_of({{0, 0, 0, 5, 5, 5}, {0, 0, 0, 5, 5, 5}}), (VertexKinds{.visible_input = 8}));
  EXPECT_EQ(kinds_of({{0, 0, 0, 9, 9, 1}, {3, 3, 1, 6, 6, 4}}),
            (VertexKinds{.visible_input = 12, .edge_face = 4}));
  EXPECT_EQ(kinds_of({{0, 0, 0, 9, 2, 2}, {0, 0, 0, 2, 9, 2}}),
            (VertexKinds{.visible_input = 10, .other = 2}));
}

TEST(Statistics, CountEveryVertexOnce) {
  std::mt19937 random(8);
  std::vector<IntegerBox> boxes;
  for (int i = 0; i < 500; ++i) {
    IntegerBox b;
    for (int a = 0; a < 3; ++a) b[a] = int(random() % 200), b[a + 3] = b[a] + 1 + int(random() % 30);
    boxes.push_back(b);
  }
  Report report;
  const MassProperties mass = measure(BoxSet(boxes), {.device = "native", .statistics = true}, &report);
  EXPECT_EQ(mass, measure(BoxSet(boxes), {.device = "native"}));
  const VertexKinds kinds = report.statistics->vertices;
  EXPECT_EQ(kinds.visible_input + kinds.edge_face + kinds.three_face + kinds.other, mass.vertices);
  EXPECT_GT(kinds.three_face, 0u);
  EXPECT_GT(report.cells.cells, 0u);
  EXPECT_GE(report.cells.items, report.cells.cells);
  EXPECT_EQ(kinds_of(boxes, Method::slices), kinds);
}

}  // namespace
}  // namespace boxunion

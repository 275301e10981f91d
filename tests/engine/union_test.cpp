// One list of cases for every way to compute a union: methods, devices, shapes, workgroup sizes and cell
// sizes. All must find the same vertices as brute force.

#include "boxunion/union.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>

#include "boxunion/octants.hpp"
#include "tests/engine/ways.hpp"
#include "tests/support/generators.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {

namespace {

BoxSet box_set(const std::vector<IntegerBox>& boxes) {
  return BoxSet(boxes);
}

Array<Vertex> brute_force(const BoxSet& boxes) {
  return brute_force_vertices(ordinal_boxes(boxes, make_axes(boxes)));
}

class Union : public testing::TestWithParam<Way> {
 protected:
  const Options& options() const { return GetParam().options; }
  bool is_native() const { return options().device == "native"; }
};

/// Random boxes with few distinct coordinates, so that all degenerate cases occur.
std::vector<IntegerBox> degenerate_boxes(std::mt19937& random, int count, int range) {
  std::vector<IntegerBox> boxes(count);
  for (IntegerBox& b : boxes)
    for (int a = 0; a < 3; ++a) {
      const int p = int(random() % range), q = int(random() % range);
      b[a] = std::min(p, q);
      b[a + 3] = std::max(p, q);
    }
  return boxes;
}

TEST_P(Union, OfNothingIsEmpty) {
  EXPECT_TRUE(unite(BoxSet(), options()).vertices.empty());
  EXPECT_EQ(measure(BoxSet(), options()), MassProperties());
  EXPECT_TRUE(unite(box_set({{0, 0, 0, 5, 5, 0}}), options()).vertices.empty());
}

TEST_P(Union, OfTouchingBoxesHasNoInnerFace) {
  const MassProperties mass = measure(box_set({{0, 0, 0, 1, 2, 3}, {1, 0, 0, 4, 2, 3}}), options());
  EXPECT_EQ(mass.vertices, 8u);
  EXPECT_EQ(mass.volume, 24);
  EXPECT_EQ(mass.area, 52);
  EXPECT_EQ(mass.edge_length, 36);
}

/// The unit cubes of an octant mask around a point, with every axis as the axis of the sweep.
TEST_P(Union, OfEveryOctantMaskAlongEveryAxisIsTheTableEntry) {
  // many masks in one run, separated from each other
  for (int rotation = 0; rotation < 3; ++rotation) {
    std::vector<IntegerBox> boxes;
    for (int mask = 0; mask < 256; ++mask)
      for (int octant = 0; octant < 8; ++octant)
        if (mask >> octant & 1) {
          IntegerBox b;
          for (int a = 0; a < 3; ++a) {
            const int axis = (a + rotation) % 3;
            b[a] = (octant >> axis & 1) + 4 * (mask >> (axis == 0   ? 0
                                                        : axis == 1 ? 3
                                                                    : 6) &
                                               (axis == 2 ? 3 : 7));
            b[a + 3] = b[a] + 1;
          }
          boxes.push_back(b);
        }
    const BoxSet set = box_set(boxes);
    const Solid solid = unite(set, options());
    ASSERT_EQ(solid.vertices, brute_force(set));
    for (int mask = 0; mask < 256; ++mask) {
      std::array<double, 3> center;
      unsigned turned = 0;
      for (int a = 0; a < 3; ++a) {
        const int axis = (a + rotation) % 3;
        center[a] = 1 + 4 * (mask >> (axis == 0 ? 0 : axis == 1 ? 3 : 6) & (axis == 2 ? 3 : 7));
      }
      for (unsigned octant = 0; octant < 8; ++octant)
        for (int a = 0; a < 3; ++a)
          if (mask >> octant & 1) {
            unsigned other = 0;
            for (int b = 0; b < 3; ++b) other |= (octant >> ((b + rotation) % 3) & 1u) << b;
            turned |= 1u << other;
          }
      const Vertex* found = nullptr;
      for (const Vertex& v : solid.vertices)
        if (solid.axes[0].coordinate(v.x) == center[0] && solid.axes[1].coordinate(v.y) == center[1] &&
            solid.axes[2].coordinate(v.z) == center[2])
          found = &v;
      EXPECT_EQ(found != nullptr, kOctants[turned].vertex) << "mask " << mask << " rotation " << rotation;
      if (found) {
        EXPECT_EQ(found->mask, turned);
      }
    }
  }
}

TEST_P(Union, OfEveryOccupancyOf2x2x3EqualsBruteForce) {
  // every occupancy on the native device; elsewhere only some, many side by side in one run
  if (is_native()) {
    for (std::uint32_t occupancy = 0; occupancy < 4096; ++occupancy) {
      const BoxSet set = box_set(unit_cubes(occupancy, 2, 2, 3));
      ASSERT_EQ(unite(set, options()).vertices, brute_force(set)) << "occupancy " << occupancy;
    }
    return;
  }
  std::vector<IntegerBox> boxes;
  for (int occupancy = 0; occupancy < 4096; ++occupancy)
    for (IntegerBox b : unit_cubes(std::uint32_t(occupancy), 2, 2, 3)) {
      const int at[3] = {3 * (occupancy & 15), 3 * (occupancy >> 4 & 15), 4 * (occupancy >> 8)};
      for (int a = 0; a < 6; ++a) b[a] += at[a % 3];
      boxes.push_back(b);
    }
  const BoxSet set = box_set(boxes);
  EXPECT_EQ(unite(set, options()).vertices, brute_force(set));
}

TEST_P(Union, OfRandomOccupanciesOf3x3x3EqualsBruteForce) {
  const unsigned seed = 20240607;
  std::mt19937 random(seed);
  std::vector<IntegerBox> boxes;
  for (int i = 0; i < 1000; ++i)
    for (IntegerBox b : unit_cubes(random() & random.max(), 3, 3, 3)) {
      const int at[3] = {4 * (i % 10), 4 * (i / 10 % 10), 4 * (i / 100)};
      for (int a = 0; a < 6; ++a) b[a] += at[a % 3];
      boxes.push_back(b);
    }
  const BoxSet set = box_set(boxes);
  EXPECT_EQ(unite(set, options()).vertices, brute_force(set)) << "seed " << seed;
}

TEST_P(Union, OfRandomDegenerateBoxesEqualsBruteForceInEveryNumber) {
  const int sets = is_native() ? 300 : 12;
  for (int seed = 0; seed < sets; ++seed) {
    std::mt19937 random(seed);
    const BoxSet set = box_set(degenerate_boxes(random, 1 + seed % 40, 3 + seed % 17));
    ASSERT_EQ(unite(set, options()).vertices, brute_force(set)) << "seed " << seed;
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < set.size(); ++i) boxes.push_back(set[i]);
    if (seed % 10 == 0) {
      ASSERT_EQ(measure(set, options()), brute_force_mass(boxes)) << "seed " << seed;
    }
  }
}

/// Moving, permuting or mirroring the boxes moves, permutes or mirrors the vertices.
TEST_P(Union, CommutesWithTheSymmetriesOfSpace) {
  std::mt19937 random(7);
  const std::vector<IntegerBox> boxes = degenerate_boxes(random, 60, 12);
  const auto points = [&](const std::vector<IntegerBox>& set, const std::array<int, 3>& axes, bool mirror,
                          int shift) {
    const Solid solid = unite(box_set(set), options());
    std::vector<std::array<double, 4>> all;
    for (const Vertex& v : solid.vertices) {
      const std::uint32_t ordinal[3] = {v.x, v.y, v.z};
      std::array<double, 4> p{};
      for (int a = 0; a < 3; ++a) {
        const double c = solid.axes[a].coordinate(ordinal[a]) - shift;
        p[axes[a]] = mirror ? -c : c;
      }
      unsigned mask = 0;
      for (unsigned octant = 0; octant < 8; ++octant) {
        unsigned image = 0;
        for (int a = 0; a < 3; ++a) image |= ((octant >> a & 1u) ^ unsigned(mirror)) << axes[a];
        mask |= (v.mask >> octant & 1u) << image;
      }
      p[3] = mask;
      all.push_back(p);
    }
    std::sort(all.begin(), all.end());
    return all;
  };
  const auto expected = points(boxes, {0, 1, 2}, false, 0);
  std::array<int, 3> axes{0, 1, 2};
  do {
    for (const bool mirror : {false, true})
      for (const int shift : is_native() ? std::vector<int>{0, -100000, 12345} : std::vector<int>{-7}) {
        std::vector<IntegerBox> image;
        for (const IntegerBox& b : boxes) {
          IntegerBox c;
          for (int a = 0; a < 3; ++a) {
            c[a] = (mirror ? -b[axes[a] + 3] : b[axes[a]]) + shift;
            c[a + 3] = (mirror ? -b[axes[a]] : b[axes[a] + 3]) + shift;
          }
          image.push_back(c);
        }
        ASSERT_EQ(points(image, axes, mirror, shift), expected);
      }
  } while (std::next_permutation(axes.begin(), axes.end()));
}

INSTANTIATE_TEST_SUITE_P(Ways, Union, testing::ValuesIn(ways()), way_name);

TEST(UnionProperty, RandomBoxesEqualBruteForce) {
  EXPECT_TRUE(rc::check("the vertices of random boxes are those of brute force", [] {
    const int range = *rc::gen::inRange(2, 9);
    const auto boxes = *rc::gen::container<std::vector<IntegerBox>>(rc::gen::map(
        rc::gen::container<std::array<int, 6>>(rc::gen::inRange(0, range)), [](std::array<int, 6> c) {
          IntegerBox b;
          for (int a = 0; a < 3; ++a) b[a] = std::min(c[a], c[a + 3]), b[a + 3] = std::max(c[a], c[a + 3]);
          return b;
        }));
    const BoxSet set(boxes);
    RC_ASSERT(unite(set, {.device = "native"}).vertices == brute_force(set));
  }));
}

TEST(UnionThreads, NeverChangeTheResult) {
  std::mt19937 random(3);
  const BoxSet set = box_set(degenerate_boxes(random, 200, 40));
  const Solid expected = unite(set, {.device = "native", .threads = 1});
  const MassProperties mass = measure(set, {.device = "native", .threads = 1});
  for (const int threads : {2, 8}) {
    EXPECT_EQ(unite(set, {.device = "native", .threads = threads}).vertices, expected.vertices);
    EXPECT_EQ(measure(set, {.device = "native", .threads = threads}), mass);
  }
}

}  // namespace
}  // namespace boxunion

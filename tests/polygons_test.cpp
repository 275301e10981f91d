#include "core/polygons.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/planes.hpp"
#include "host/engine.hpp"
#include "tests/generators.hpp"
#include "tests/rectangles.hpp"

namespace boxunion {
namespace {

using Loop = std::vector<std::array<double, 2>>;
using Polygons = std::vector<std::vector<Loop>>;

/// The faces of one direction, with the position of each point.
template <class Position>
Polygons spelled_out(const Faces& faces, unsigned direction, Position&& position) {
  Polygons polygons;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces.direction[f] != direction) continue;
    polygons.emplace_back();
    for (std::size_t l = faces.first_loop[f]; l < faces.first_loop[f + 1]; ++l) {
      polygons.back().emplace_back();
      for (const std::uint32_t point : faces.loop(l)) polygons.back().back().push_back(position(point));
    }
  }
  return polygons;
}

constexpr unsigned kUp = 4;

template <class T>
Polygons by_plane(const Rectangles<T>& rectangles) {
  const Contour contour = find_contour(rectangles);
  const Faces faces = find_polygons(contour);
  for (const auto direction : faces.direction) EXPECT_EQ(direction, kUp);
  return spelled_out(faces, kUp,
                     [&](std::uint32_t point) { return contour.position(contour.vertices[point]); });
}

/// The upper faces of the boxes of unit height that stand on the rectangles.
template <class T>
Polygons by_boxes(const Rectangles<T>& rectangles) {
  const Solid solid = unite(unit_boxes(rectangles), {.device = "native"});
  const Planes planes = make_planes(solid);
  const Points points(solid, planes, NonManifold::keep);
  const Array<Point> positions = points.positions();
  return spelled_out(find_faces(planes, points), kUp, [&](std::uint32_t point) {
    return std::array{positions[point][0], positions[point][1]};
  });
}

RC_GTEST_PROP(Polygons, OfSmallIntegersAreFacesOfBoxes, ()) {
  const auto rectangles = *rectangles_from<double>(small_integer(), 9, 20);
  RC_ASSERT(by_plane(rectangles) == by_boxes(rectangles));
}

RC_GTEST_PROP(Polygons, OfAnyDoublesAreFacesOfBoxes, ()) {
  const auto rectangles = *rectangles_from<double>(nasty_coordinate(), 9, 20);
  RC_ASSERT(by_plane(rectangles) == by_boxes(rectangles));
}

TEST(Polygons, OfManyRectanglesAreFacesOfBoxes) {
  int set = 0;
  for (const auto& rectangles : large_sets<std::int32_t>()) {
    SCOPED_TRACE(set++);
    EXPECT_TRUE(by_plane(rectangles) == by_boxes(rectangles));
  }
}

/// In how many groups the members of a square grid share edges, or also corners.
int groups(std::uint64_t members, int side, bool corners) {
  int count = 0;
  while (members != 0) {
    std::vector<int> reached = {std::countr_zero(members)};
    members &= members - 1;
    ++count;
    while (!reached.empty()) {
      const int x = reached.back() % side, y = reached.back() / side;
      reached.pop_back();
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u) {
          if (u < 0 || v < 0 || u >= side || v >= side || (!corners && u != x && v != y)) continue;
          const int i = v * side + u;
          if (members >> i & 1u) reached.push_back(i), members &= ~(std::uint64_t{1} << i);
        }
    }
  }
  return count;
}

TEST(Polygons, OfEveryOccupancy) {
  for (unsigned occupancy = 0; occupancy < 1u << 16; ++occupancy) {
    const Polygons polygons = by_plane(unit_squares(occupancy, 4));
    double area = 0;
    int holes = 0;
    for (const auto& polygon : polygons)
      for (std::size_t l = 0; l < polygon.size(); ++l) {
        double enclosed = 0;
        const Loop& loop = polygon[l];
        for (std::size_t i = 0; i < loop.size(); ++i) {
          const auto &p = loop[i], &q = loop[(i + 1) % loop.size()];
          ASSERT_NE(p[0] == q[0], p[1] == q[1]) << occupancy;  // each edge runs along one axis
          enclosed += (p[0] * q[1] - q[0] * p[1]) / 2;
        }
        ASSERT_EQ(enclosed > 0, l == 0) << occupancy;
        holes += l > 0;
        area += enclosed;
      }
    ASSERT_EQ(area, std::popcount(occupancy)) << occupancy;
    ASSERT_EQ(int(polygons.size()), groups(occupancy, 4, false)) << occupancy;
    // what is outside, within a border of empty squares: holes are all its groups but one, and touch by
    // corners too
    std::uint64_t empty = 0;
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) {
        const bool border = x == 0 || y == 0 || x == 5 || y == 5;
        if (border || !(occupancy >> ((y - 1) * 4 + x - 1) & 1u)) empty |= std::uint64_t{1} << (y * 6 + x);
      }
    ASSERT_EQ(holes, groups(empty, 6, true) - 1) << occupancy;
  }
}

/// Loops that go up and down again through all rows: frames in each other with slits, and much between.
Rectangles<std::int32_t> frames_with_slits() {
  Rectangles<std::int32_t> all = scattered<std::int32_t>(6000, 12000, 60, 60, 3);
  constexpr int kFrames = 40, kSide = 20000;
  for (int i = 0; i < kFrames; ++i) {
    const int lo = 200 * i, hi = kSide - lo, slit = kSide / 2 + 7 * i;
    append(all, {{lo, lo, lo + 100, hi},
                 {hi - 100, lo, hi, hi},
                 {lo, lo, slit, lo + 100},
                 {slit + 5, lo, hi, lo + 100}});
    append(all, i % 2 ? Rectangles<std::int32_t>{{lo, hi - 100, hi, hi}}
                      : Rectangles<std::int32_t>{{lo, hi - 100, slit, hi}, {slit + 9, hi - 100, hi, hi}});
  }
  return all;
}

/// Frames in each other, so that holes and polygons alternate inwards, and much between; far more vertices
/// than columns.
Rectangles<std::int32_t> nested_frames() {
  constexpr int kFrames = 40, kSide = 4000;
  Rectangles<std::int32_t> all = scattered<std::int32_t>(60000, kSide, 6, 6, 5);
  for (int i = 0; i < kFrames; ++i) {
    const int lo = 40 * i, hi = kSide - lo;
    append(all, {{lo, lo, hi, lo + 5}, {lo, hi - 5, hi, hi}, {lo, lo, lo + 5, hi}, {hi - 5, lo, hi, hi}});
  }
  return all;
}

TEST(Polygons, OfFramesInEachOtherAreFacesOfBoxesOnManyThreads) {
  const tbb::global_control eight(tbb::global_control::max_allowed_parallelism, 8);
  const auto rectangles = nested_frames();
  EXPECT_TRUE(tbb::task_arena(8).execute([&] { return by_plane(rectangles); }) == by_boxes(rectangles));
}

TEST(Polygons, DoNotDependOnThreads) {
  const tbb::global_control eight(tbb::global_control::max_allowed_parallelism, 8);
  auto sets = large_sets<std::int32_t>();
  sets.push_back(frames_with_slits());
  sets.push_back(nested_frames());
  sets.push_back(scattered<std::int32_t>(100000, 30000, 90, 90, 9));
  for (const auto& rectangles : sets) {
    const Contour contour = find_contour(rectangles);
    const auto found = [&](int threads) {
      return tbb::task_arena(threads).execute([&] { return find_polygons(contour); });
    };
    const Faces one = found(1);
    for (const int threads : {2, 3, 8}) {
      const Faces many = found(threads);
      EXPECT_TRUE(many.loop_points == one.loop_points);
      EXPECT_TRUE(many.first_point == one.first_point);
      EXPECT_TRUE(many.first_loop == one.first_loop);
    }
  }
}

TEST(Polygons, OfNothing) {
  EXPECT_TRUE(by_plane(Rectangles<double>{}).empty());
}

TEST(Polygons, EndWhenInterrupted) {
  const Contour contour = find_contour(Rectangles<double>{{0, 0, 1, 1}});
  const std::atomic<bool> flag = true;
  const Interruptible scope(&flag);
  EXPECT_THROW(find_polygons(contour), Error);
}

}  // namespace
}  // namespace boxunion

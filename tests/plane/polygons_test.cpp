// Boost.Geometry includes a header that Boost itself marks as deprecated, with a message.
#define BOOST_ALLOW_DEPRECATED_HEADERS

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <boost/geometry/algorithms/is_valid.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "boxunion/contour.hpp"
#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/base/parallel.hpp"
#include "core/boundary/faces.hpp"
#include "core/boundary/planes.hpp"
#include "core/boundary/points.hpp"
#include "tests/plane/rectangles.hpp"
#include "tests/support/generators.hpp"

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

/// Cuts the loop at the first vertex that it visits a second time, repeatedly. The parts between visits come
/// after the loop, starting at their lowest vertices. Quadratic.
void cut_where_touching(std::vector<Loop>& polygon, std::size_t loop) {
  for (std::size_t j = 1; j < polygon[loop].size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      Loop& all = polygon[loop];
      if (all[i] != all[j]) continue;
      const auto begin = all.begin() + std::ptrdiff_t(i), end = all.begin() + std::ptrdiff_t(j);
      Loop hole(begin, end);
      const auto lowest = std::ranges::min_element(hole, {}, [](const auto& p) {
        return std::array{p[1], p[0]};
      });
      std::rotate(hole.begin(), lowest, hole.end());
      all.erase(begin, end);
      polygon.push_back(std::move(hole));
      j = i;
      break;
    }
}

/// Polygons whose loops visit each vertex once.
Polygons simple(Polygons polygons) {
  for (auto& polygon : polygons) {
    const std::size_t loops = polygon.size();
    for (std::size_t l = 0; l < loops; ++l) cut_where_touching(polygon, l);
    std::ranges::sort(polygon.begin() + 1, polygon.end(), {}, [](const Loop& hole) {
      return std::array{hole[0][1], hole[0][0]};
    });
  }
  return polygons;
}

/// The upper faces of boxes of height 1 over the rectangles.
template <class T>
Polygons by_boxes(const Rectangles<T>& rectangles) {
  const Solid solid = unite(unit_boxes(rectangles), {.device = "native"});
  const Planes planes = make_planes(solid);
  const Points points(solid, planes, NonManifold::keep);
  const Array<Point> positions = points.positions();
  return simple(spelled_out(find_faces(planes, points), kUp, [&](std::uint32_t point) {
    return std::array{positions[point][0], positions[point][1]};
  }));
}

/// Validity according to Boost.Geometry: loops are simple, holes lie inside, and the inside is connected.
bool is_valid(const std::vector<Loop>& polygon) {
  namespace bg = boost::geometry;
  using BoostPoint = bg::model::d2::point_xy<double>;
  bg::model::polygon<BoostPoint, false, false> theirs;
  theirs.inners().resize(polygon.size() - 1);
  for (std::size_t l = 0; l < polygon.size(); ++l)
    for (const auto& [x, y] : polygon[l])
      (l == 0 ? theirs.outer() : theirs.inners()[l - 1]).push_back(BoostPoint(x, y));
  return bg::is_valid(theirs);
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

/// The parts of a square grid that are connected by edges.
std::vector<std::uint64_t> parts(std::uint64_t members, int side) {
  std::vector<std::uint64_t> all;
  const auto take = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= side || y >= side) return false;
    const std::uint64_t bit = std::uint64_t{1} << (y * side + x);
    if ((members & bit) == 0) return false;
    members ^= bit;
    all.back() |= bit;
    return true;
  };
  while (members != 0) {
    std::vector<int> reached = {std::countr_zero(members)};
    all.push_back(members & -members);
    members &= members - 1;
    while (!reached.empty()) {
      const int x = reached.back() % side, y = reached.back() / side;
      reached.pop_back();
      for (const auto& [u, v] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}})
        if (take(u, v)) reached.push_back(v * side + u);
    }
  }
  return all;
}

/// The number of holes in the parts of a 4 x 4 grid: for each part, all components of its complement except
/// the outer one.
int holes_in_parts(unsigned occupancy) {
  int holes = 0;
  for (const std::uint64_t part : parts(occupancy, 4)) {
    std::uint64_t within_border = 0;
    for (int y = 0; y < 4; ++y) within_border |= (part >> (4 * y) & 15u) << (6 * (y + 1) + 1);
    holes += int(parts(~within_border & ((std::uint64_t{1} << 36) - 1), 6).size()) - 1;
  }
  return holes;
}

TEST(Polygons, OfEveryOccupancy) {
  for (unsigned occupancy = 0; occupancy < 1u << 16; ++occupancy) {
    const Polygons polygons = by_plane(unit_squares(occupancy, 4));
    double area = 0;
    int holes = 0;
    for (const auto& polygon : polygons) {
      ASSERT_TRUE(is_valid(polygon)) << occupancy;
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
    }
    ASSERT_EQ(area, std::popcount(occupancy)) << occupancy;
    ASSERT_EQ(polygons.size(), parts(occupancy, 4).size()) << occupancy;
    ASSERT_EQ(holes, holes_in_parts(occupancy)) << occupancy;
  }
}

/// Loops that go up and down through all rows: nested frames with slits, and many squares between them.
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

/// Nested frames, so that holes and polygons alternate inwards, and many squares between them. There are far
/// more vertices than columns.
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

TEST(Polygons, HolesThatTouchAreTwo) {
  const auto polygons = by_plane(
      Rectangles<double>{{0, 0, 1, 4}, {3, 0, 4, 4}, {0, 0, 4, 1}, {0, 3, 4, 4}, {1, 1, 2, 2}, {2, 2, 3, 3}});
  const Loop outer{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  EXPECT_EQ(polygons,
            (Polygons{{outer, {{2, 1}, {2, 2}, {3, 2}, {3, 1}}, {{1, 2}, {1, 3}, {2, 3}, {2, 2}}}}));
}

TEST(Polygons, RingThatTouchesItselfHasAHole) {
  const auto polygons = by_plane(Rectangles<double>{{0, 0, 3, 1}, {0, 0, 1, 3}, {0, 2, 2, 3}, {2, 1, 3, 2}});
  const Loop outer{{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 3}, {0, 3}};
  EXPECT_EQ(polygons, (Polygons{{outer, {{1, 1}, {1, 2}, {2, 2}, {2, 1}}}}));
}

TEST(Polygons, OfRandomSquaresAreValid) {
  rc::check([] {
    const auto rectangles = *rectangles_from<double>(small_integer(), 9, 40);
    for (const auto& polygon : by_plane(rectangles)) RC_ASSERT(is_valid(polygon));
  });
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

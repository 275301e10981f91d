#include "boxunion/contour.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <ostream>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/base/parallel.hpp"
#include "tests/plane/rectangles.hpp"
#include "tests/support/generators.hpp"

namespace boxunion {
namespace {

/// A vertex with its coordinates.
struct Corner {
  double x, y;
  unsigned quadrants;
  friend bool operator==(const Corner&, const Corner&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Corner& c) {
    return out << '(' << c.x << ' ' << c.y << ' ' << c.quadrants << ')';
  }
};

std::vector<Corner> corners(const Contour& contour) {
  std::vector<Corner> result;
  for (const ContourVertex& v : contour.vertices) {
    const auto [x, y] = contour.position(v);
    result.push_back({x, y, v.quadrants});
  }
  return result;
}

/// The definition, applied to each cell between all coordinates.
struct Reference {
  std::vector<Corner> corners;
  mpq_class area = 0, perimeter = 0;
};

template <class T>
Reference reference(const Rectangles<T>& rectangles) {
  std::array<std::vector<double>, 2> c;
  for (const auto& r : rectangles)
    for (unsigned i = 0; i < 4; ++i) c[i % 2].push_back(double(r[i]));
  for (auto& axis : c) {
    std::ranges::sort(axis);
    axis.erase(std::unique(axis.begin(), axis.end()), axis.end());
  }
  // true if the cell above places i - 1 and j - 1 is inside
  const auto inside = [&](std::size_t i, std::size_t j) {
    if (i == 0 || j == 0 || i == c[0].size() || j == c[1].size()) return false;
    return std::ranges::any_of(rectangles, [&](const auto& r) {
      return double(r[0]) <= c[0][i - 1] && c[0][i] <= double(r[2]) && double(r[1]) <= c[1][j - 1] &&
             c[1][j] <= double(r[3]);
    });
  };
  const auto length = [](double from, double to) { return mpq_class(mpq_class(to) - mpq_class(from)); };
  Reference result;
  for (std::size_t j = 0; j < c[1].size(); ++j)
    for (std::size_t i = 0; i < c[0].size(); ++i) {
      const bool q[4] = {inside(i, j), inside(i + 1, j), inside(i, j + 1), inside(i + 1, j + 1)};
      const bool along_x = q[0] != q[1] || q[2] != q[3], along_y = q[0] != q[2] || q[1] != q[3];
      if (along_x && along_y)
        result.corners.push_back(
            {c[0][i] + 0., c[1][j] + 0., unsigned(q[0] | q[1] << 1 | q[2] << 2 | q[3] << 3)});
      if (q[3]) result.area += length(c[0][i], c[0][i + 1]) * length(c[1][j], c[1][j + 1]);
      if (q[1] != q[3]) result.perimeter += length(c[0][i], c[0][i + 1]);
      if (q[2] != q[3]) result.perimeter += length(c[1][j], c[1][j + 1]);
    }
  return result;
}

/// True if x is a double nearest to an exact number.
bool is_rounded(double x, const mpq_class& exact) {
  if (std::isinf(x)) return exact > mpq_class(std::numeric_limits<double>::max());
  const auto error = [&](double y) {
    return std::isinf(y) ? exact + 1 : mpq_class(abs(mpq_class(y) - exact));
  };
  return error(x) <= error(std::nextafter(x, 0)) && error(x) <= error(std::nextafter(x, x + INFINITY));
}

template <class T>
void check(const Rectangles<T>& rectangles) {
  const Contour contour = find_contour(rectangles);
  const Reference expected = reference(rectangles);
  RC_ASSERT(corners(contour) == expected.corners);
  const ContourProperties properties = measure(contour);
  RC_ASSERT(is_rounded(properties.area, expected.area));
  RC_ASSERT(is_rounded(properties.perimeter, expected.perimeter));
}

RC_GTEST_PROP(Contour, OfSmallIntegers, ()) {
  check(*rectangles_from<double>(small_integer()));
}

RC_GTEST_PROP(Contour, OfAnyDoubles, ()) {
  check(*rectangles_from<double>(nasty_coordinate()));
}

RC_GTEST_PROP(Contour, OfDecimals, ()) {
  check(*rectangles_from<double>(decimal(), 40, 40));
}

RC_GTEST_PROP(Contour, OfWideIntegers, ()) {
  check(*rectangles_from<std::int32_t>(rc::gen::arbitrary<std::int32_t>(), 60, 60));
}

TEST(Contour, OfEveryOccupancy) {
  for (unsigned occupancy = 0; occupancy < 1u << 16; ++occupancy) {
    const auto squares = unit_squares(occupancy, 4);
    ASSERT_EQ(corners(find_contour(squares)), reference(squares).corners) << occupancy;
  }
}

TEST(Contour, OfNothing) {
  EXPECT_TRUE(find_contour({}).vertices.empty());
  const Contour degenerate = find_contour(std::vector<Rectangle>{{1, 2, 1, 5}, {0.1, 3, 0.7, 3}});
  EXPECT_TRUE(degenerate.vertices.empty());
  EXPECT_EQ(measure(degenerate).area, 0);
  EXPECT_EQ(measure(degenerate).perimeter, 0);
}

// ---- larger sets, against the boxes of unit height that stand on the rectangles ----

template <class T>
std::vector<Corner> by_boxes(const Rectangles<T>& rectangles) {
  const Solid solid = unite(unit_boxes(rectangles), {.device = "native"});
  std::vector<Corner> result;
  for (const Vertex& v : solid.vertices)
    if (solid.axes[2].coordinate(v.z) == 0)
      result.push_back({solid.axes[0].coordinate(v.x), solid.axes[1].coordinate(v.y), v.mask >> 4});
  return result;
}

template <class T>
void expect_same_as_boxes() {
  int set = 0;
  for (const Rectangles<T>& rectangles : large_sets<T>()) {
    SCOPED_TRACE(set++);
    const Contour contour = find_contour(rectangles);
    EXPECT_TRUE(corners(contour) == by_boxes(rectangles));
    for (const int threads : {1, 2})
      tbb::task_arena(threads).execute([&] {
        Rectangles<T> turned(rectangles.rbegin(), rectangles.rend());
        EXPECT_TRUE(find_contour(turned).vertices == contour.vertices);
      });
  }
}

TEST(Contour, OfManyIntegersIsThatOfBoxes) {
  expect_same_as_boxes<std::int32_t>();
}

TEST(Contour, OfManyDoublesIsThatOfBoxes) {
  expect_same_as_boxes<double>();
}

TEST(Contour, DoesNotDependOnThreads) {
  const tbb::global_control eight(tbb::global_control::max_allowed_parallelism, 8);
  for (const int side : {1, 60}) {  // strips of one cell, and of many
    const auto rectangles = scattered<std::int32_t>(100000, 30000, side, side, 9);
    const auto found = [&](int threads) {
      return tbb::task_arena(threads).execute([&] { return find_contour(rectangles).vertices; });
    };
    EXPECT_TRUE(found(1) == found(8)) << side;
  }
}

// Strips of one cell each. Those in the middle are halved from left to right.
TEST(Contour, OfFewRectanglesAndACrowdIsThatOfBoxes) {
  auto rectangles = scattered<std::int32_t>(2000, 1000000, 100, 100, 1);
  for (auto r : scattered<std::int32_t>(300, 5000, 100, 100, 2))
    rectangles.push_back({r[0] + 500000, r[1] + 500000, r[2] + 500000, r[3] + 500000});
  EXPECT_TRUE(corners(find_contour(rectangles)) == by_boxes(rectangles));
}

TEST(Contour, NamesTheFirstInvalidRectangle) {
  const auto message = [](const Rectangle& bad) -> std::string {
    try {
      find_contour(std::vector<Rectangle>{{0, 0, 1, 1}, bad, {0, 0, -1, 1}});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message({0, 3, 1, 2}), "rectangle 2: ymin is 3 and ymax is 2, expected ymin <= ymax");
  EXPECT_EQ(message({0, 0, NAN, 2}), "rectangle 2: xmax is nan, expected a finite number");
  EXPECT_EQ(message({0, -INFINITY, 1, 2}), "rectangle 2: ymin is -inf, expected a finite number");
}

TEST(Contour, EndsWhenInterrupted) {
  const std::atomic<bool> flag = true;
  const Interruptible scope(&flag);
  EXPECT_THROW(find_contour(scattered<std::int32_t>(1000, 30000, 60, 60, 10)), Error);
}

}  // namespace
}  // namespace boxunion

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <set>

#include "boxunion/rectangle.hpp"
#include "core/boxes/ordinals.hpp"
#include "tests/support/generators.hpp"

namespace boxunion {
namespace {

/// The x axis of boxes that reach from each coordinate to the greatest one.
Axis axis_of(const std::vector<double>& coordinates) {
  const double most = *std::max_element(coordinates.begin(), coordinates.end());
  std::vector<Box> boxes;
  for (const double x : coordinates) boxes.push_back({x, 0, 0, most, 1, 1});
  return make_axes(boxes)[0];
}

void expect_lattice(const std::vector<double>& coordinates, int exponent, std::uint32_t count) {
  const Axis axis = axis_of(coordinates);
  ASSERT_TRUE(axis.is_lattice());
  EXPECT_EQ(axis.exponent(), exponent);
  EXPECT_EQ(axis.count(), count);
  for (const double x : coordinates) EXPECT_EQ(axis.coordinate(axis.ordinal(x)), x);
}

void expect_rank(const std::vector<double>& coordinates) {
  const Axis axis = axis_of(coordinates);
  ASSERT_FALSE(axis.is_lattice());
  for (const double x : coordinates) EXPECT_EQ(axis.coordinate(axis.ordinal(x)), x);
}

TEST(Axis, LatticeIsTheCoarsestPowerOfTwo) {
  expect_lattice({0, 1, 5}, 0, 6);
  expect_lattice({0, 8, 24}, 3, 4);
  expect_lattice({8, 12}, 2, 2);
  expect_lattice({-0.5, 0.25, 3}, -2, 15);
  expect_lattice({-0.0, 0.0}, 0, 1);
}

TEST(Axis, LatticeReachesEveryExponent) {
  expect_lattice({std::ldexp(1.0, 1000)}, 1000, 1);
  expect_lattice({-0x1p1023, 0x1p1023}, 1023, 3);
  expect_lattice({-1.7976931348623157e308}, 971, 1);
  expect_lattice({5e-324}, -1074, 1);
  expect_lattice({-5e-324, 0, 5e-324, 50e-324}, -1074, 12);
  expect_lattice({0x1.8p-1060, 0x1p-1050}, -1061, 2046);
  expect_lattice({9007199254740991, 9007199254740992, 9007199254740994}, 0, 4);
}

TEST(Axis, LatticeHasRoomForAllButTwoOrdinals) {
  expect_lattice({0, 1, 4294967293.0}, 0, 0xfffffffeu);
  expect_lattice({-2147483647.0, 2147483646.0}, 0, 0xfffffffeu);
  expect_rank({0, 1, 4294967294.0});
  expect_rank({-2147483647.0, 2147483647.0});
}

TEST(Axis, CoordinatesFarApartAreRanked) {
  expect_rank({1e-300, 1e300});
  expect_rank({-1.7976931348623157e308, 5e-324, 1.7976931348623157e308});
  expect_rank({0.1, 1e15 + 0.1, -0.0, -3});
  expect_rank({1, 1 / 3., 5e-324});
}

TEST(Axis, OneFineCoordinateAmongManyIsFound) {
  for (std::size_t lane = 0; lane < 6; ++lane)
    for (const double unit : {0x1p-1060, 0x1p-3, 1.0, 0x1p40, 0x1p1000}) {
      std::vector<Box> boxes;
      for (int i = 0; i < 1000; ++i)
        boxes.push_back({-16 * unit, i * unit, 0, 1024 * unit, 1024 * unit, 2048 * unit});
      ASSERT_EQ(make_axes(boxes)[1].exponent(), std::ilogb(unit));
      boxes[777][lane] = unit / 4;
      const Axis fine = make_axes(boxes)[lane % 3];
      EXPECT_TRUE(fine.is_lattice());
      EXPECT_EQ(fine.exponent(), std::ilogb(unit) - 2);
      boxes[777][lane] = 0x1p-1072;
      const Axis finest = make_axes(boxes)[lane % 3];
      EXPECT_EQ(finest.is_lattice(), unit == 0x1p-1060);
      EXPECT_EQ(finest.coordinate(finest.ordinal(0x1p-1072)), 0x1p-1072);
    }
}

TEST(Axis, IntegersMakeLatticesOverTheirWholeRange) {
  constexpr std::int32_t least = -2147483647 - 1, most = 2147483645;
  const Axes axes = make_axes(std::vector<IntegerBox>{{least, -6, 0, most, 6, 0}, {0, -3, 0, 1, 0, 0}});
  EXPECT_EQ(axes[0].count(), 0xfffffffeu);
  EXPECT_EQ(axes[0].coordinate(1), least);
  EXPECT_EQ(axes[0].ordinal(most), 0xfffffffeu);
  EXPECT_EQ(axes[1].count(), 13u);
  EXPECT_EQ(axes[2].count(), 1u);
  EXPECT_FALSE(make_axes(std::vector<IntegerBox>{{least, 0, 0, 2147483647, 1, 1}})[0].is_lattice());
}

/// The exponent of the lowest bit of a double that is not 0, found by halving.
int lowest_bit(double x) {
  int exponent = 0;
  double fraction = std::frexp(x, &exponent);
  for (; fraction != std::floor(fraction); fraction *= 2) --exponent;
  return exponent;
}

/// The axis of rows of one coordinate each, in one of the six columns of boxes. The other end on that axis is
/// the coordinate of the first row.
Axis axis_of_rows(const std::vector<double>& rows, std::size_t lane) {
  std::vector<Box> boxes(rows.size(), Box{1, 1, 1, 1, 1, 1});  // zeros would skip the fast test
  for (std::size_t i = 0; i < rows.size(); ++i) boxes[i][lane] = rows[i], boxes[i][(lane + 3) % 6] = rows[0];
  const Axis axis = make_axes(boxes)[lane % 3];
  if (lane % 3 == 2) return axis;
  std::vector<Rectangle> rectangles(rows.size(), Rectangle{1, 1, 1, 1});
  for (std::size_t i = 0; i < rows.size(); ++i)
    rectangles[i][lane % 3] = rows[lane < 3 ? i : 0], rectangles[i][lane % 3 + 2] = rows[lane < 3 ? 0 : i];
  LatticeScan scan;
  scan.add(RectangleSet(rectangles));
  EXPECT_EQ(scan.plane_axes()[lane % 3].count(), axis.is_lattice() ? axis.count() : 0u);
  return axis;
}

/// Checks that the axis is right when `last` follows a block of the scan filled with `many`, a multiple of
/// 2^e.
void expect_last_is_seen(int e, double many, double last) {
  if (!std::isfinite(last) || last == 0 || !std::isfinite(many)) return;
  const int exponent = std::min(lowest_bit(many), lowest_bit(last));
  for (const std::size_t before : {1u, 127u, 128u, 255u}) {
    std::vector<double> rows(before + 1, many);
    rows[0] = many + std::ldexp(many < 0 ? -1 : 1, e);
    if (!std::isfinite(rows[0]) || lowest_bit(rows[0]) < e) return;
    rows.push_back(last);
    const Axis axis = axis_of_rows(rows, before % 6);
    for (const double x : rows)
      ASSERT_EQ(axis.coordinate(axis.ordinal(x)), x) << std::hexfloat << many << last;
    const int unit = std::min(exponent, lowest_bit(rows[0]));
    const auto [least, most] = std::ranges::minmax(rows);
    const long double steps = std::ldexp(static_cast<long double>(most) - least, -unit);
    ASSERT_EQ(axis.is_lattice(), steps < 4294967294.0L) << std::hexfloat << many << ' ' << last;
    if (axis.is_lattice()) {
      ASSERT_EQ(axis.exponent(), unit) << std::hexfloat << many << ' ' << last;
    }
  }
}

TEST(Axis, EveryBinadeOfEveryUnitIsSeenInEveryBlock) {
  for (int e = -1074; e <= 971; e += e < -1066 || e > 965 || std::abs(e) < 2 ? 1 : 97)
    for (const int binade : {0, 1, 2, 15, 31, 32, 48, 49, 50, 51, 52, 53})
      for (const double sign : {-1.0, 1.0})
        for (const double many : {0x1p0, std::ldexp(1.0, binade), std::ldexp(1.5, binade)})
          for (const double edge : {std::ldexp(1.0, binade), std::ldexp(1.5, binade)})
            for (const double step : {-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0})
              expect_last_is_seen(e, sign * std::ldexp(many, e), sign * std::ldexp(edge + step, e));
}

/// Random rows close to one point: a power of two or three times a random unit, with few bits below the unit.
/// Some fill a block of the scan with a run.
std::vector<double> random_rows(std::mt19937_64& random) {
  const int e = int(random() % 2000) - 1040;
  const double near =
      (random() % 2 ? 1 : -1) * std::ldexp(1.0 + 0.5 * double(random() % 2), int(random() % 55));
  std::vector<double> rows;
  for (std::size_t runs = 1 + random() % 4; runs > 0; --runs) {
    const double steps = std::ldexp(double(random() % 64) - 32, -int(random() % 3));
    const double x = std::ldexp(random() % 16 == 0 ? steps : near + steps, e);
    constexpr std::size_t kLengths[] = {1, 1, 2, 127, 128, 129};
    rows.insert(rows.end(), kLengths[random() % std::size(kLengths)], std::isfinite(x) ? x : 0);
  }
  return rows;
}

TEST(Axis, DoesNotDependOnTheOrderOfRows) {
  std::mt19937_64 random(20);
  for (int set = 0; set < 200000; ++set) {
    std::vector<double> rows = random_rows(random);
    const std::size_t lane = random() % 6;
    const Axis axis = axis_of_rows(rows, lane);
    if (set % 2)
      std::ranges::reverse(rows);
    else
      std::ranges::shuffle(rows, random);
    const Axis other = axis_of_rows(rows, lane);
    ASSERT_EQ(axis.is_lattice(), other.is_lattice()) << "set " << set;
    ASSERT_EQ(axis.count(), other.count()) << "set " << set;
    ASSERT_EQ(axis.exponent(), other.exponent()) << "set " << set;
    for (const double x : rows) {
      ASSERT_EQ(axis.ordinal(x), other.ordinal(x)) << "set " << set;
      ASSERT_EQ(axis.coordinate(axis.ordinal(x)), x) << "set " << set;
    }
  }
}

TEST(Axis, EveryPermutationOfFewRowsIsTheSame) {
  for (const double big : {0x1p51, 0x1.8p51, 0x1p52, 0x1.8p52, 0x1p53}) {
    std::vector<std::pair<double, std::size_t>> runs = {
        {-big, 128}, {-big + 0.5, 1}, {-big + 3, 128}, {-big - 8, 1}};
    std::ranges::sort(runs);
    std::optional<Axis> first;
    do {
      std::vector<double> rows;
      for (const auto& [x, count] : runs) rows.insert(rows.end(), count, x);
      const Axis axis = axis_of_rows(rows, 1);
      if (!first) first = axis;
      EXPECT_EQ(axis.is_lattice(), first->is_lattice());
      EXPECT_EQ(axis.exponent(), first->exponent());
      for (const double x : rows) ASSERT_EQ(axis.coordinate(axis.ordinal(x)), x);
    } while (std::ranges::next_permutation(runs).found);
  }
}

TEST(Axis, AxesAreIndependent) {
  const Axes axes = make_axes(std::vector<Box>{{0, 0.5, 1e-300, 4, 1, 1e300}});
  EXPECT_EQ(axes[0].exponent(), 2);
  EXPECT_EQ(axes[1].exponent(), -1);
  EXPECT_FALSE(axes[2].is_lattice());
}

TEST(Axis, NoBoxesHaveNoOrdinals) {
  for (const Axis& axis : make_axes(BoxSet{})) EXPECT_EQ(axis.count(), 0u);
  for (const Axis& axis : make_rank_axes(BoxSet{})) EXPECT_EQ(axis.count(), 0u);
}

/// Checks that ordinals keep the order of the coordinates and map back to them.
void check_axes(const std::vector<Box>& boxes, const Axes& axes) {
  for (unsigned a = 0; a < 3; ++a) {
    std::set<double> coordinates;
    for (const Box& box : boxes) coordinates.insert({box[a], box[a + 3]});
    std::uint32_t last = Axis::kOrdinalMin;
    for (const double x : coordinates) {
      const std::uint32_t ordinal = axes[a].ordinal(x);
      RC_ASSERT(axes[a].coordinate(ordinal) == x);
      RC_ASSERT(last < ordinal);
      last = ordinal;
    }
    RC_ASSERT(axes[a].count() == last);
  }
}

RC_GTEST_PROP(Axis, OrdinalsAreExactAndOrdered, ()) {
  const std::vector<Box> boxes =
      *rc::gen::oneOf(boxes_from(small_integer()), boxes_from(decimal()), boxes_from(nasty_coordinate()));
  check_axes(boxes, make_axes(boxes));
  check_axes(boxes, make_rank_axes(boxes));
}

TEST(Axis, OrdinalBoxesKeepTheirOrderAndDropDegenerateOnes) {
  std::vector<IntegerBox> boxes;
  std::vector<OrdinalBox> expected;
  for (std::int32_t i = 0; i < 100'000; ++i) {  // several chunks
    boxes.push_back({i, 0, 0, i + i % 3, 1, 1});
    const auto x = static_cast<std::uint32_t>(i + 1);
    if (i % 3 != 0) expected.push_back({{x, 1, 1}, {x + x % 3 - 1 + (x % 3 == 0) * 3, 2, 2}});
  }
  const Axes axes = make_axes(boxes);
  const std::vector<OrdinalBox> result = ordinal_boxes(boxes, axes);
  ASSERT_EQ(result.size(), expected.size());
  EXPECT_TRUE(result == expected);
  EXPECT_TRUE(ordinal_boxes(boxes, make_rank_axes(boxes)).size() == expected.size());
}

/// Checks that every box maps back exactly, and that every ordinal of a rank axis occurs.
void check_ordinals(const BoxSet& boxes) {
  const Ordinals ordinals = make_ordinals(boxes);
  std::array<std::set<std::uint32_t>, 3> used;
  std::size_t next = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box box = boxes[i];
    if (box[0] == box[3] || box[1] == box[4] || box[2] == box[5]) continue;
    ASSERT_LT(next, ordinals.boxes.size());
    const OrdinalBox& found = ordinals.boxes[next++];
    for (unsigned a = 0; a < 3; ++a) {
      ASSERT_EQ(ordinals.axes[a].coordinate(found.lo[a]), box[a]);
      ASSERT_EQ(ordinals.axes[a].coordinate(found.hi[a]), box[a + 3]);
      if (!ordinals.axes[a].is_lattice()) used[a].insert({found.lo[a], found.hi[a]});
    }
  }
  ASSERT_EQ(ordinals.boxes.size(), next);
  const Axes axes = make_axes(boxes);
  for (unsigned a = 0; a < 3; ++a) {
    if (ordinals.axes[a].is_lattice()) continue;
    ASSERT_FALSE(axes[a].is_lattice());
    ASSERT_EQ(ordinals.axes[a].count(), used[a].size());
    for (std::uint32_t ordinal = 2; ordinal <= ordinals.axes[a].count(); ++ordinal)
      ASSERT_LT(ordinals.axes[a].coordinate(ordinal - 1), ordinals.axes[a].coordinate(ordinal));
  }
  if (count_degenerate(boxes) == 0) {
    ASSERT_TRUE(ordinals.boxes == ordinal_boxes(boxes, axes));
  }
}

RC_GTEST_PROP(Ordinals, AreExactAndOrdered, ()) {
  check_ordinals(
      *rc::gen::oneOf(boxes_from(small_integer()), boxes_from(decimal()), boxes_from(nasty_coordinate())));
}

/// `count` boxes with `distinct` coordinates on each axis. The axes in the bits of `ranks` are no lattices.
std::vector<Box> mixed_boxes(std::size_t count, unsigned ranks, std::uint32_t distinct) {
  std::mt19937_64 random(count + ranks);
  std::vector<Box> boxes(count);
  for (Box& box : boxes)
    for (unsigned a = 0; a < 3; ++a) {
      const double unit = ranks >> a & 1u ? 0.1 : 0.25;
      const auto i = static_cast<double>(random() % distinct);
      box[a] = (i - 3) * unit;
      box[a + 3] = (i - 3 + static_cast<double>(random() % 5)) * unit;
      if (ranks >> a & 1u && i == 3) box[a] = -0.0;
    }
  if (count > 2) boxes[count / 2] = {1e-300, 1e-300, 1e-300, 1e300, 1e300, 1e300};
  for (unsigned a = 0; a < 3; ++a)
    if (count > 2 && !(ranks >> a & 1u)) boxes[count / 2][a] = 0, boxes[count / 2][a + 3] = 1;
  return boxes;
}

TEST(Ordinals, OfEveryMixtureOfAxes) {
  for (unsigned ranks = 0; ranks < 8; ++ranks)
    for (const std::size_t count : {0, 1, 2, 15, 16, 17, 16'384, 16'385, 40'000})
      for (const std::uint32_t distinct : {4u, 1'000'000u})
        check_ordinals(mixed_boxes(count, ranks, distinct));
}

TEST(Ordinals, OfAMillionBoxesOnAnyNumberOfThreads) {
  const BoxSet boxes(mixed_boxes(1'000'000, 5, 10'000'000));
  check_ordinals(boxes);
  const Ordinals expected = make_ordinals(boxes);
  for (const int threads : {1, 2, 5})
    tbb::task_arena(threads).execute([&] { EXPECT_TRUE(make_ordinals(boxes).boxes == expected.boxes); });
}

TEST(Ordinals, OfDegenerateBoxesAlone) {
  const Ordinals ordinals = make_ordinals(std::vector<Box>{{0.1, 1e-300, 0, 0.1, 1e300, 1}});
  EXPECT_TRUE(ordinals.boxes.empty());
}

TEST(Ordinals, OfIntegersTooFarApartForALattice) {
  check_ordinals(std::vector<IntegerBox>{{-2147483647 - 1, 0, 0, 2147483647, 1, 1}, {0, 0, 0, 5, 5, 5}});
}

}  // namespace
}  // namespace boxunion

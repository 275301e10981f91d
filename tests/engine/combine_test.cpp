// Boolean expressions over sets of boxes, computed in every way: compared with brute force on voxels, and
// with the laws of sets.

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <random>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "core/models/sections.hpp"
#include "tests/engine/expressions.hpp"
#include "tests/engine/sweep.hpp"
#include "tests/engine/ways.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

/// The ways that support expressions.
std::vector<Way> boolean_ways() {
  std::vector<Way> all = ways();
  std::erase_if(all, [](const Way& way) {
    return way.options.method == Method::slices || way.options.kernel == CellKernel::faces;
  });
  return all;
}

Options native() {
  return {.device = "native"};
}

/// True for the sets in which an expression holds.
Combination combination_of(const Expression& expression) {
  return [&expression](std::uint64_t sets) {
    return evaluate(expression.steps(), [sets](std::uint32_t i) { return (sets >> i & 1u) != 0; });
  };
}

Array<Vertex> brute_force(const Expression& expression, const std::vector<BoxSet>& sets) {
  Ordinals ordinals = make_ordinals(sets);
  std::vector<std::vector<OrdinalBox>> boxes;
  std::size_t begin = 0;
  for (const std::size_t end : ordinals.ends) {
    boxes.emplace_back(ordinals.boxes.begin() + std::ptrdiff_t(begin),
                       ordinals.boxes.begin() + std::ptrdiff_t(end));
    begin = end;
  }
  return brute_force_vertices(boxes, combination_of(expression));
}

MassProperties brute_force_numbers(const Expression& expression, const std::vector<BoxSet>& sets) {
  std::vector<std::vector<Box>> boxes(sets.size());
  for (std::size_t s = 0; s < sets.size(); ++s)
    for (std::size_t i = 0; i < sets[s].size(); ++i) boxes[s].push_back(sets[s][i]);
  return brute_force_mass(boxes, combination_of(expression));
}

/// Random boxes with few distinct coordinates, so that all degenerate cases occur.
std::vector<IntegerBox> random_boxes(std::mt19937& random, std::size_t count, int range) {
  std::vector<IntegerBox> boxes(count);
  for (IntegerBox& b : boxes)
    for (std::size_t a = 0; a < 3; ++a) {
      const int p = int(random() % unsigned(range)), q = int(random() % unsigned(range));
      b[a] = std::min(p, q);
      b[a + 3] = std::max(p, q);
    }
  return boxes;
}

/// The same with real coordinates: `scale` times an integer. One of them is far from the others.
std::vector<Box> real_boxes(std::mt19937& random, std::size_t count, int range) {
  std::vector<Box> boxes;
  for (const IntegerBox& b : random_boxes(random, count, range)) {
    Box box;
    for (std::size_t c = 0; c < 6; ++c) box[c] = b[c] == 1 ? 1e-17 : 0.1 * b[c];
    boxes.push_back(box);
  }
  return boxes;
}

/// The sets that an expression names, in its order. A, B, ... or N0, N1, ... stand for the sets of `sets`.
std::vector<BoxSet> named(const Expression& expression, const std::vector<BoxSet>& sets) {
  std::vector<BoxSet> all;
  for (const std::string& name : expression.names())
    all.push_back(sets.at(name.size() == 1 ? std::size_t(name[0] - 'A') : std::stoul(name.substr(1))));
  return all;
}

class Combine : public testing::TestWithParam<Way> {
 protected:
  const Options& options() const { return GetParam().options; }
  bool is_native() const { return options().device == "native"; }
  int cases(int natively) const { return is_native() ? natively : natively / 20; }

  /// Compares the vertices, and every number, with brute force.
  void check(const std::string& text, const std::vector<BoxSet>& all, bool numbers = true) const {
    const Expression expression = Expression::parse(text);
    const std::vector<BoxSet> sets = named(expression, all);
    Report report;
    ASSERT_EQ(combine(expression, sets, options(), &report).vertices, brute_force(expression, sets)) << text;
    if (!report.device.empty()) {  // there was something to do
      ASSERT_EQ(report.device, options().device);
    }
    if (numbers) {
      ASSERT_EQ(measure(expression, sets, options()), brute_force_numbers(expression, sets)) << text;
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Ways, Combine, testing::ValuesIn(boolean_ways()), way_name);

TEST_P(Combine, RandomExpressionsOfRandomBoxesEqualBruteForce) {
  for (int seed = 0; seed < cases(400); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random{unsigned(seed)};
    const auto operands = std::uint32_t(1 + seed % 6);
    const std::string text = random_expression(operands, random);
    std::vector<BoxSet> sets;
    for (std::uint32_t i = 0; i < operands; ++i)
      sets.emplace_back(random_boxes(random, random() % (seed % 3 == 0 ? 30 : 5), 3 + seed % 17));
    ASSERT_NO_FATAL_FAILURE(check(text, sets, seed % 4 == 0));
  }
}

TEST_P(Combine, RealCoordinatesAreExactToo) {
  for (int seed = 0; seed < cases(60); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random{unsigned(seed)};
    const std::string text = random_expression(3, random);
    std::vector<BoxSet> sets;
    for (int i = 0; i < 3; ++i) {
      if (seed % 3 == i)
        sets.emplace_back(random_boxes(random, 3, 2));  // integers among the doubles
      else
        sets.emplace_back(real_boxes(random, random() % 8, 7));
    }
    ASSERT_NO_FATAL_FAILURE(check(text, sets, seed % 4 == 0));
  }
}

TEST_P(Combine, IntegersAndFractionsShareALattice) {
  const std::vector<BoxSet> sets{std::vector<IntegerBox>{{0, 0, 0, 4, 4, 4}, {8, 0, -4, 12, 4, 4}},
                                 std::vector<Box>{{0.25, 1, 1, 3, 9.5, 2}, {-7, 0.5, 0, 11, 1.75, 1}}};
  for (const char* text : {"A not B", "B not A", "A and B", "A xor B", "A or B"}) check(text, sets);
}

TEST_P(Combine, OfOneSetIsItsUnion) {
  std::mt19937 random(5);
  const std::vector<BoxSet> sets{random_boxes(random, 50, 12)};
  for (const char* text : {"A", "A or A", "A and A", "A xor A", "A not A", "A not (A not A)"})
    check(text, sets);
  EXPECT_EQ(measure(Expression::parse("A not A"), sets, options()), MassProperties());
}

TEST_P(Combine, TouchingSetsShareNoVolumeAndSplitCleanly) {
  const std::vector<BoxSet> sets{std::vector<IntegerBox>{{0, 0, 0, 2, 2, 2}},
                                 std::vector<IntegerBox>{{2, 0, 0, 4, 2, 2}, {0, 0, 2, 2, 2, 4}}};
  EXPECT_EQ(measure(Expression::parse("A and B"), sets, options()), MassProperties());
  EXPECT_EQ(measure(Expression::parse("A not B"), sets, options()).vertices, 8u);
  for (const char* text : {"A or B", "A xor B", "B not A", "A and B", "A not B"}) check(text, sets);
}

TEST_P(Combine, EmptySetsAreNothing) {
  const std::vector<BoxSet> sets{std::vector<IntegerBox>{{0, 0, 0, 3, 4, 5}}, BoxSet(),
                                 std::vector<IntegerBox>{{1, 1, 1, 2, 2, 1}}};
  for (const char* text :
       {"A or B or C", "A and B and C", "A not B not C", "(B or C) not A", "A xor B xor C"})
    check(text, sets);
  const std::vector<BoxSet> none(2);
  EXPECT_EQ(measure(Expression::parse("A not B"), none, options()), MassProperties());
  EXPECT_TRUE(combine(Expression::parse("A xor B"), none, options()).vertices.empty());
}

TEST_P(Combine, ASetThatCoversEverythingIsTheUniverse) {
  std::mt19937 random(11);
  for (const int range : {9, 200}) {
    std::vector<BoxSet> sets;
    for (int i = 0; i < 2; ++i) sets.emplace_back(random_boxes(random, range == 9 ? 8 : 4, range));
    sets.emplace_back(std::vector<IntegerBox>{{-5, -5, -5, range + 5, range + 5, range + 5}});
    for (const char* text :
         {"(A or B) and C", "C not A not B", "C not (A and B)", "C xor A or B", "A and B not C"}) {
      check(text, sets);
    }
  }
}

/// A not B, with holes of B so far apart that cells, and natively tiles, lie inside A without any box.
TEST_P(Combine, HolesFarApartLeaveTheRestFilled) {
  std::vector<IntegerBox> holes;
  for (int i = 0; i < 9; ++i)
    holes.push_back({1000 * i, 900 * i, 800 * i, 1000 * i + 3, 900 * i + 3, 800 * i + 3});
  check("A not B", {std::vector<IntegerBox>{{-1, -1, -1, 9000, 9000, 9000}}, holes});
}

TEST_P(Combine, ManySetsThatAllMeet) {
  std::mt19937 random(3);
  std::string text = "N0";
  std::vector<BoxSet> sets;
  for (int i = 0; i < 40; ++i) {
    const int lo = i % 7;
    sets.emplace_back(std::vector<IntegerBox>{
        {lo, (3 * i) % 11, (5 * i) % 13, lo + 9, (3 * i) % 11 + 8, (5 * i) % 13 + 7}});
    if (i > 0)
      text = fmt::format("({}) {} N{}", text,
                         std::array{"or", "xor", "not", "and"}[i < 36 ? i % 3 : 3 * (i % 2)], i);
  }
  check(text, sets);
}

TEST_P(Combine, NestedDifferencesGoDeep) {
  // an onion: A0 not (A1 not (A2 not ...)), in which every other shell is filled
  std::string text, ends;
  std::vector<BoxSet> sets;
  for (int i = 0; i < 12; ++i) {
    text += fmt::format("{}A{}", i ? " not (" : "", i);
    if (i) ends += ")";
    sets.emplace_back(std::vector<IntegerBox>{{i, i, i, 25 - i, 24 - i, 26 - i}});
  }
  check(text + ends, sets);
}

/// Cells with more boxes than a kernel can hold at a time.
TEST_P(Combine, CrowdedCellsEqualBruteForce) {
  std::mt19937 random(17);
  const std::vector<BoxSet> sets{random_boxes(random, 900, 5), random_boxes(random, 30, 5),
                                 random_boxes(random, 400, 5)};
  for (const char* text : {"A not B", "A and B and C", "B xor C xor A", "B not (A not C)"}) check(text, sets);
  // thin boxes with much space between them
  std::vector<BoxSet> rods;
  for (int s = 0; s < 3; ++s) {
    std::vector<IntegerBox> boxes;
    for (int i = 0; i < 300; ++i) {
      IntegerBox b = random_boxes(random, 1, 8)[0];
      const auto a = std::size_t(s);
      for (std::size_t c = 0; c < 3; ++c)
        if (c != a) b[c + 3] = b[c] + 1;
      boxes.push_back(b);
    }
    rods.emplace_back(boxes);
  }
  for (const char* text : {"A and B", "A xor B xor C", "(A or B) and C", "(A and B) xor (B and C)"})
    check(text, rods);
}

/// The laws of sets, on inputs too large for voxels. Both sides must have the same vertices.
TEST_P(Combine, ObeysTheLawsOfSets) {
  const int n = is_native() ? 1000 : 100;
  for (const int edge : {300, 900}) {
    std::vector<BoxSet> sets;
    for (std::uint64_t seed = 1; seed <= 3; ++seed)
      sets.push_back(collect(generate_boxes(std::uint64_t(n), 1, edge, 8192, seed)));
    const auto solid = [&](const std::string& text) {
      const Expression e = Expression::parse(text);
      const std::vector<BoxSet> used = named(e, sets);
      Solid s = combine(e, used, options());
      std::vector<std::array<double, 4>> points;
      for (const Vertex& v : s.vertices)
        points.push_back({s.axes[0].coordinate(v.x), s.axes[1].coordinate(v.y), s.axes[2].coordinate(v.z),
                          double(v.mask)});
      std::ranges::sort(points);
      // sums and vertices must agree
      MassSink sink(s.axes);
      sink.add(s.vertices);
      EXPECT_EQ(measure(e, used, options()), sink.result()) << text;
      return points;
    };
    EXPECT_EQ(solid("A not (B or C)"), solid("(A not B) and (A not C)"));
    EXPECT_EQ(solid("A not (B and C)"), solid("(A not B) or (A not C)"));
    EXPECT_EQ(solid("A and (B or C)"), solid("(A and B) or (A and C)"));
    EXPECT_EQ(solid("A or (B and C)"), solid("(A or B) and (A or C)"));
    EXPECT_EQ(solid("A xor B"), solid("(A or B) not (A and B)"));
    EXPECT_EQ(solid("A xor (B xor C)"), solid("(C xor A) xor B"));
  }
}

TEST(CombineVolumes, ObeyInclusionAndExclusionExactly) {
  std::vector<BoxSet> sets;
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    sets.push_back(collect(generate_boxes(20000, 1, 400, 8192, seed)));
  const auto volume = [&](const std::string& text) {
    const Expression e = Expression::parse(text);
    const std::vector<BoxSet> used = named(e, sets);
    return measure(e, used, native()).volume;  // an integer below 2^53
  };
  EXPECT_EQ(volume("A or B or C"), volume("A") + volume("B") + volume("C") - volume("A and B") -
                                       volume("B and C") - volume("C and A") + volume("A and B and C"));
  EXPECT_EQ(volume("A xor B"), volume("A") + volume("B") - 2 * volume("A and B"));
}

TEST_P(Combine, EqualsTheSweepOfSections) {
  std::mt19937 random(11);
  for (int round = 0; round < (is_native() ? 6 : 2); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const Expression expression = Expression::parse(random_expression(4, random));
    std::vector<BoxSet> sets;
    for (std::size_t i = 0; i < expression.names().size(); ++i) {
      if (round % 2 == 0)
        sets.emplace_back(random_boxes(random, 60, 40));
      else
        sets.emplace_back(real_boxes(random, 40, 30));
    }
    const Solid found = combine(expression, sets, options());
    for (const AxisOrder& order : kAxisOrders)
      ASSERT_EQ(sweep(expression, sets, found.axes, order).vertices, make_evm(found, order).vertices);
  }
}

/// A million copies and nested boxes. The work must be near-linear, by the grid's own counters.
TEST(CombineCrowds, HiddenBoxesCostNoWork) {
  constexpr int n = 50000;
  std::vector<IntegerBox> copies(1000000, {0, 0, 0, 60000, 60000, 60000}), nested, cubes;
  for (int i = 0; i < n; ++i) nested.push_back({5, 5, 5, i + 6, i + 6, i + 6});
  for (int i = 0; i < n; ++i) cubes.push_back({i, i, i, i + 3, i + 3, i + 3});
  const std::vector<BoxSet> sets{copies, nested, cubes};
  Report report;
  const MassProperties mass = measure(Expression::parse("A not B not C"), sets, native(), &report);
  EXPECT_LT(report.cells.cells + report.cells.items, std::size_t{2} * n * 16);
  EXPECT_EQ(mass.volume,
            60000.0 * 60000 * 60000 - std::pow(n, 3) -
                (measure(Expression::parse("C not B"), std::vector<BoxSet>{cubes, nested}, native()).volume));
  EXPECT_EQ(measure(Expression::parse("A and B"), std::vector<BoxSet>{copies, nested}, native()).volume,
            std::pow(n, 3));
}

TEST(CombineRefuses, UnsupportedOptions) {
  const std::vector<BoxSet> sets(2);
  const Expression e = Expression::parse("A not B");
  const auto expect_usage = [](auto&& f) {
    try {
      f();
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::usage) << error.what();
    }
  };
  expect_usage([&] { measure(e, std::span(sets).first(1), native()); });
  expect_usage([&] { measure(e, sets, {.method = Method::slices, .device = "native"}); });
  expect_usage([&] { combine(e, sets, {.kernel = CellKernel::faces, .device = "native"}); });
  expect_usage([&] { measure(e, sets, {.device = "native", .statistics = true}); });
  const std::vector<BoxSet> wrong{BoxSet(), std::vector<IntegerBox>{{1, 0, 0, 0, 1, 1}}};
  EXPECT_THROW(measure(e, wrong, native()), Error);
}

/// A union of several sets is found like any other union, by every method.
TEST(CombineUnions, AreFoundInEveryWay) {
  std::mt19937 random(23);
  const std::vector<BoxSet> sets{random_boxes(random, 9, 9), real_boxes(random, 9, 9),
                                 random_boxes(random, 3, 12)};
  const Expression e = Expression::parse("A or B or C");
  for (const Way& way : ways(list_devices()))
    EXPECT_EQ(combine(e, sets, way.options).vertices, brute_force(e, sets)) << way.name;
}

}  // namespace
}  // namespace boxunion

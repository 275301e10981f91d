#include "boxunion/box.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

constexpr Box kUnit = {0, 0, 0, 1, 1, 1};

std::string validation_error(const BoxSet& boxes) {
  try {
    validate(boxes);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    return error.what();
  }
  return "";
}

TEST(Box, IntegersBecomeDoublesOnAccess) {
  const BoxSet boxes(std::vector<IntegerBox>{{-2147483647 - 1, 0, 1, 2, 3, 2147483647}});
  EXPECT_EQ(boxes[0], (Box{-2147483648.0, 0, 1, 2, 3, 2147483647.0}));
}

TEST(Box, NanInfinityAndReversedBoxesAreNamed) {
  Box box = kUnit;
  box[1] = std::nan("");
  EXPECT_EQ(validation_error(std::vector<Box>{kUnit, box}), "box 2: ymin is nan, expected a finite number");
  box[1] = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(validation_error(std::vector<Box>{box}), "box 1: ymin is -inf, expected a finite number");
  box[1] = 1.5;
  EXPECT_EQ(validation_error(std::vector<Box>{box}),
            "box 1: ymin is 1.5 and ymax is 1, expected ymin <= ymax");
  EXPECT_EQ(validation_error(std::vector<IntegerBox>{{0, 0, 3, 1, 1, 2}}),
            "box 1: zmin is 3 and zmax is 2, expected zmin <= zmax");
  EXPECT_EQ(validation_error(std::vector<Box>{}), "");
}

TEST(Box, TheFirstInvalidBoxIsNamedHoweverTheWorkIsShared) {
  std::vector<Box> boxes(1'000'000, kUnit);
  for (const std::size_t bad : {999'999u, 700'001u, 300'007u}) {
    boxes[bad][0] = 2;
    EXPECT_EQ(find_invalid(boxes), bad);
  }
}

TEST(Box, ZeroThicknessIsValidAndCounted) {
  std::vector<IntegerBox> boxes(200'000, {0, 0, 0, 1, 1, 1});
  boxes[5] = {0, 0, 0, 0, 1, 1};
  boxes[199'999] = {0, 0, 0, 0, 0, 0};
  EXPECT_EQ(validation_error(boxes), "");
  EXPECT_EQ(count_degenerate(boxes), 2u);
  EXPECT_EQ(count_degenerate(std::vector<Box>{{-0.0, 0, 0, 0.0, 1, 1}}), 1u);
}

}  // namespace
}  // namespace boxunion

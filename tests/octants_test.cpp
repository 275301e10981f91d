#include "core/octants.hpp"

#include <gtest/gtest.h>

namespace boxunion {
namespace {

TEST(Octants, TableHas218VerticesAnd128ExtremeOnes) {
  int vertices = 0, extreme = 0;
  for (const OctantProperties& p : kOctants) {
    vertices += p.vertex;
    extreme += p.extreme;
  }
  EXPECT_EQ(vertices, 218);
  EXPECT_EQ(extreme, 128);
}

}  // namespace
}  // namespace boxunion

#include "boxunion/octants.hpp"

#include <gtest/gtest.h>

#include "core/boundary/points.hpp"
#include "core/solid/fans.hpp"

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

TEST(Fans, HoldEveryFacetAndSplitEveryContact) {
  std::array<int, 5> masks{};  // by number of fans
  int pinched = 0;             // masks with a non-manifold edge whose sectors belong to one fan
  for (unsigned mask = 0; mask < 256; ++mask) {
    const MaskFans& fans = kFans[mask];
    ASSERT_LE(fans.count, 4);
    ++masks[fans.count];
    unsigned seen = 0;
    for (unsigned octant = 0; octant < 8; ++octant)
      for (unsigned axis = 0; axis < 3; ++axis) {
        const bool facet = mask >> octant & 1u && !(mask >> (octant ^ 1u << axis) & 1u);
        EXPECT_EQ(facet, fans.of[octant][axis] != MaskFans::kNone);
        if (facet) seen |= 1u << fans.of[octant][axis];
      }
    EXPECT_EQ(seen, (1u << fans.count) - 1);
    bool is_pinched = false;
    for (unsigned direction = 0; direction < 6; ++direction) {
      const auto& [first, second] = fans.at_edge[direction];
      EXPECT_EQ(kOctants[mask].edges[direction], (first != MaskFans::kNone) + (second != MaskFans::kNone));
      is_pinched |= first != MaskFans::kNone && first == second;
    }
    pinched += is_pinched;
  }
  EXPECT_EQ(masks[0], 2);
  EXPECT_EQ(masks[4], 2);  // the class of 01101001
  EXPECT_EQ(pinched, 36);
}

}  // namespace
}  // namespace boxunion

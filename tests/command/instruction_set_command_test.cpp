#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/command/command.hpp"

// BOXUNION_CPU, as a user sets it.

namespace boxunion {
namespace {

using namespace std::string_literals;

TEST_F(Command, TheNativeDeviceNamesItsInstructionSet) {
  const Outcome best = shell("BOXUNION_CPU= boxunion devices");
  const Outcome baseline = shell("BOXUNION_CPU=baseline boxunion devices");
  EXPECT_NE(baseline.out.find("oneTBB, baseline"), std::string::npos) << baseline.out << baseline.err;
  if (best.out.find("oneTBB, baseline") == std::string::npos) {
    EXPECT_EQ(shell("BOXUNION_CPU=x86-64-v3 boxunion devices").out, best.out);
  } else {  // this CPU has nothing better
    EXPECT_EQ(shell("BOXUNION_CPU=x86-64-v3 boxunion devices").status, 2);
  }
}

TEST_F(Command, TheInstructionSetChangesNoBitOfAResult) {
  // sparse cubes become clusters, large boxes cells of a grid
  for (const char* const input : {"cubes --count 3000 --edge 300", "boxes --count 2000 --max-edge 4000"}) {
    ASSERT_EQ(run("generate "s + input + " -o boxes.npy").status, 0);
    for (const char* const set : {"baseline", ""}) {
      const std::string run = "BOXUNION_CPU="s + set + " boxunion boundary boxes.npy --device native ";
      ASSERT_EQ(shell(run + "-o vertices" + set + ".csv").status, 0);
      ASSERT_EQ(
          shell("BOXUNION_CPU="s + set + " boxunion measure boxes.npy --device native --json >mass" + set)
              .status,
          0);
    }
    EXPECT_EQ(folder_.read("vertices.csv"), folder_.read("verticesbaseline.csv"));
    const auto best = nlohmann::json::parse(folder_.read("mass")),
               baseline = nlohmann::json::parse(folder_.read("massbaseline"));
    for (const char* const property : {"vertices", "volume", "area", "edge_length", "centroid", "inertia"})
      EXPECT_EQ(best.at(property), baseline.at(property)) << property;
  }
}

TEST_F(Command, AnUnknownInstructionSetIsAUsageError) {
  ASSERT_EQ(run("generate cubes --count 9 --edge 300 -o boxes.npy").status, 0);
  const Outcome r = shell("BOXUNION_CPU=avx512 boxunion measure boxes.npy");
  EXPECT_EQ(r.status, 2);
  EXPECT_EQ(r.out, "");
  EXPECT_EQ(r.err, "boxunion: error: BOXUNION_CPU: expected baseline or x86-64-v3, found 'avx512'\n");
}

}  // namespace
}  // namespace boxunion

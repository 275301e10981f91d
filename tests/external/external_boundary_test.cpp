// Boundaries of solids that do not fit memory have the same files and counts as those from memory.

#include "host/external/external_boundary.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "tests/command/command.hpp"
#include "tests/external/external_inputs.hpp"
#include "tests/support/boxes_in_memory.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

const Options kNative{.device = "native"};

ExternalBoundary write_within(const BoxSet& boxes, NonManifold contacts, bool triangles_only,
                              const Budget& budget, const std::string& path) {
  const BoxesInMemory file(boxes);
  Report report;
  ExternalUnion solid(file, kNative, budget, report);
  return write_boundary(solid, contacts, triangles_only, open_output(path, FileUse::boundary), report);
}

/// The inputs of external_inputs, and touching boxes that lie on no lattice.
std::vector<Input> inputs() {
  std::vector<Input> all = external_inputs();
  std::mt19937_64 random(std::random_device{}());
  std::vector<Box> tenths;
  for (int i = 0; i < 900; ++i) {
    Box& box = tenths.emplace_back();
    for (std::size_t a = 0; a < 3; ++a) {
      const int at = int(random() % 10);
      box[a] = 0.1 * at, box[a + 3] = 0.1 * (at + 1);
    }
  }
  all.push_back({"tenths", tenths});
  return all;
}

TEST(ExternalBoundary, IsTheSameToTheByteInEveryFormat) {
  std::mt19937_64 random(std::random_device{}());
  const TemporaryFolder folder, scratch;
  std::size_t midpoints = 0;
  for (const Input& input : inputs()) {
    const Solid solid = unite(input.boxes, kNative);
    for (const NonManifold contacts : {NonManifold::keep, NonManifold::split}) {
      const Boundary expected = find_boundary(solid, contacts, kNative);
      if (contacts == NonManifold::split) {
        std::uint64_t fans = 0;
        for (const Vertex& v : solid.vertices) fans += kFans[v.mask].count;
        midpoints += expected.brep.points.size() - fans;
      }
      constexpr std::array kFiles = {"a.ply", "a.stl", "a.obj", "a.off", "a.3mf", "a.npy", "a.csv"};
      const std::size_t first = random();
      for (const std::string name : {kFiles[first % kFiles.size()], kFiles[(first + 1) % kFiles.size()]}) {
        SCOPED_TRACE(input.name + " " + name + (contacts == NonManifold::keep ? " keep" : " split"));
        const bool triangles_only = random() % 2 == 0;
        const std::string path = folder.file(name);
        if (is_mesh(path))
          write_mesh(expected.brep, expected.triangulation, triangles_only,
                     open_output(path, FileUse::boundary));
        else
          write_vertices(solid, open_output(path));
        // planes of some thousand vertices at a time, unless one plane has more
        const bool deep = input.name == "wide" || input.name == "large" || input.name == "degenerate";
        const bool flat = input.name == "one plane" || input.name == "checkerboard";
        const Budget budget{std::uint64_t{flat ? 1024u : 101u} << 20, scratch.path(),
                            deep                        ? 0
                            : input.name == "clustered" ? 1500u
                                                        : 500u};
        const std::string in_memory = folder.read(name);
        const ExternalBoundary found = write_within(input.boxes, contacts, triangles_only, budget, path);
        EXPECT_TRUE(folder.read(name) == in_memory);
        EXPECT_EQ(found.vertices.vertices, solid.vertices.size());
        EXPECT_EQ(found.counts.faces, expected.brep.faces.size());
        EXPECT_EQ(found.counts.holes, expected.brep.faces.holes());
        EXPECT_EQ(found.counts.triangles, expected.triangulation.triangles.size());
        ASSERT_TRUE(found.counts.shells);
        EXPECT_EQ(found.counts.shells->shells, expected.brep.shells.size());
        EXPECT_EQ(found.counts.shells->cavities, expected.brep.shells.cavities());
        EXPECT_EQ(scratch.file_count(), 0u);
      }
    }
  }
  EXPECT_GT(midpoints, 10u);
}

TEST(ExternalBoundary, SaysWhatAPlaneThatDoesNotFitNeeds) {
  std::vector<IntegerBox> pillars;
  for (int x = 0; x < 100; ++x)
    for (int y = 0; y < 100; ++y) pillars.push_back({2 * x, 2 * y, 0, 2 * x + 1, 2 * y + 1, 1 + x + y});
  const TemporaryFolder folder, scratch;
  try {
    write_within(pillars, NonManifold::keep, false, {std::uint64_t{100} << 20, scratch.path()},
                 folder.file("a.ply"));
    FAIL() << "it fits";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::resources);
    EXPECT_STREQ(error.what(),
                 "a plane of 40000 vertices does not fit the budget: expected --memory of at least 136 MiB");
  }
  EXPECT_EQ(folder.file_count(), 0u);
  EXPECT_EQ(scratch.file_count(), 0u);
  EXPECT_EQ(write_within(pillars, NonManifold::keep, false, {std::uint64_t{136} << 20, scratch.path()},
                         folder.file("a.ply"))
                .counts.faces,
            60'000u);
}

TEST_F(Command, MeshesKeepToTheBudget) {
  if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any limit";
  run("generate boxes --count 100000 --max-edge 60 -o a.npy --quiet");
  const auto results = [](nlohmann::json json) {
    for (const char* key : {"seconds", "slabs"}) json.erase(key);
    return json;
  };
  for (const std::string file : {"a.ply", "a.stl", "a.3mf"}) {
    const std::string boundary = " boundary a.npy --json --quiet --device native --threads 2 -o " + file;
    const Outcome expected = run(boundary);
    const std::string bytes = folder_.read(file);
    const Outcome r = shell("ulimit -v 320000; boxunion" + boundary + " --memory 106M");
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.err, expected.err);
    EXPECT_EQ(results(nlohmann::json::parse(r.out)), results(nlohmann::json::parse(expected.out)));
    EXPECT_TRUE(folder_.read(file) == bytes);
  }
  EXPECT_TRUE(run("boundary a.npy -o a.ply --memory 101M")
                  .err.starts_with("boxunion: warning: shells are not counted: counting takes"));
}

}  // namespace
}  // namespace boxunion

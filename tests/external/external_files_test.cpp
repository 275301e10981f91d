// Unions of files within a budget, by the public functions only: the same numbers and bytes as from memory.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "boxunion/boxunion.hpp"
#include "tests/external/external_inputs.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

const Options kNative{.device = "native"};

TEST(ExternalFiles, HaveTheResultsFromMemory) {
  const TemporaryFolder folder, scratch;
  const Budget budget{.bytes = std::uint64_t{1} << 30, .scratch = scratch.path(), .slab_boxes = 700};
  const std::vector<Input> inputs = external_inputs();
  std::uint64_t slabs = 0;
  for (const Input& input : inputs) {
    SCOPED_TRACE(input.name);
    const std::string boxes = folder.file("boxes.npy");
    write_boxes(input.boxes, boxes);
    ExternalReport report;
    EXPECT_EQ(measure_file(boxes, budget, kNative, {}, &report), measure(input.boxes, kNative));
    EXPECT_EQ(report.boxes, input.boxes.size());
    EXPECT_EQ(report.degenerate_boxes, count_degenerate(input.boxes));
    slabs += report.slabs;

    const Solid solid = unite(input.boxes, kNative);
    const Boundary boundary = find_boundary(solid, NonManifold::split, kNative);
    const BoundaryCounts counts =
        write_boundary(boxes, folder.file("within.ply"), budget, NonManifold::split, false, kNative);
    EXPECT_TRUE(write_mesh(boundary.brep, boundary.triangulation, folder.file("memory.ply")));
    EXPECT_TRUE(folder.read("within.ply") == folder.read("memory.ply"));
    EXPECT_EQ(counts.triangles, boundary.triangulation.triangles.size());

    const Decomposition disjoint = decompose(make_evm_of_fewest_boxes(solid, BoxModel::cudb), BoxModel::cudb);
    EXPECT_EQ(write_decomposition(boxes, folder.file("within.csv"), budget, BoxModel::cudb, {}, kNative),
              disjoint.boxes.size());
    write_boxes(to_boxes(disjoint), folder.file("memory.csv"));
    EXPECT_TRUE(folder.read("within.csv") == folder.read("memory.csv"));
  }
  EXPECT_GT(slabs, 2 * inputs.size());
  EXPECT_EQ(scratch.file_count(), 0u);
}

TEST(ExternalFiles, LeaveNoOutputWhereTheInputIsWrong) {
  const TemporaryFolder folder;
  const Budget budget{.bytes = std::uint64_t{1} << 30, .scratch = folder.path()};
  const std::string bad = folder.write("bad.csv", "0,0,0,1,1\n");
  EXPECT_THROW(measure_file(bad, budget), Error);
  EXPECT_THROW(write_boundary(bad, folder.file("out.ply"), budget), Error);
  EXPECT_THROW(write_boundary(bad, folder.file("out.csv"), budget), Error);  // not a mesh format
  EXPECT_THROW(write_decomposition(bad, folder.file("out.npy"), budget), Error);
  EXPECT_EQ(folder.file_count(), 1u);
}

/// The triangles of a binary STL file: the normal, the corners and the attributes of each.
std::vector<std::string> triangles_of(const std::string& stl) {
  std::vector<std::string> all;
  for (std::size_t at = 84; at < stl.size(); at += 50) all.push_back(stl.substr(at, 50));
  std::ranges::sort(all);
  return all;
}

TEST(MeshFiles, OfTrianglesAloneAreThoseOfTheBoundary) {
  const TemporaryFolder folder;
  const BoxSet boxes = collect(generate_boxes(300, 1, 30, 100, 7));
  const Solid solid = unite(boxes, kNative);
  const Mesh mesh = make_mesh(solid, NonManifold::split);
  const Boundary boundary = find_boundary(solid, NonManifold::split, kNative);
  ASSERT_EQ(mesh.triangles.size(), boundary.triangulation.triangles.size());
  const auto written = [&](const char* name) {
    EXPECT_TRUE(write_mesh(mesh, folder.file(name)));
    const std::string text = folder.read(name);
    EXPECT_TRUE(write_mesh(boundary.brep, boundary.triangulation, folder.file(name), true));
    return std::array{text, folder.read(name)};
  };
  const auto [stl, expected_stl] = written("a.stl");
  EXPECT_TRUE(triangles_of(stl) == triangles_of(expected_stl));
  for (const char* name : {"a.ply", "a.obj", "a.off"}) {
    SCOPED_TRACE(name);
    auto [text, expected] = written(name);
    ASSERT_EQ(text.size(), expected.size());
    std::ranges::sort(text);  // the same faces in another order
    std::ranges::sort(expected);
    EXPECT_TRUE(text == expected);
  }
}

}  // namespace
}  // namespace boxunion

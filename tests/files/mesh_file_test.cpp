// Meshes as files. Tiny readers of our own read back what was written.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "host/files/files.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

using Polygons = std::vector<std::vector<std::uint32_t>>;

struct Read {
  Array<Point> points;
  Polygons polygons;
};

Read read_obj(const std::string& text) {
  Read mesh;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Point p;
      for (double& c : p) words >> c;
      mesh.points.push_back(p);
    } else if (kind == "f") {
      mesh.polygons.emplace_back();
      for (std::uint32_t i; words >> i;) mesh.polygons.back().push_back(i - 1);
    } else {
      EXPECT_EQ(line, "# boxunion");
    }
  }
  return mesh;
}

Read read_off(const std::string& text) {
  Read mesh;
  std::istringstream words(text);
  std::string magic;
  std::size_t points, polygons, edges;
  words >> magic >> points >> polygons >> edges;
  EXPECT_EQ(magic, "OFF");
  mesh.points.resize(points);
  for (Point& p : mesh.points)
    for (double& c : p) words >> c;
  mesh.polygons.resize(polygons);
  for (auto& polygon : mesh.polygons) {
    std::size_t size;
    words >> size;
    polygon.resize(size);
    for (std::uint32_t& i : polygon) words >> i;
  }
  EXPECT_TRUE(words);
  return mesh;
}

template <class T>
T take(const char*& bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  bytes += sizeof value;
  return value;
}

Read read_ply(const std::string& text) {
  Read mesh;
  const auto count = [&](const std::string& element) {
    return std::stoul(text.substr(text.find("element " + element + " ") + 9 + element.size()));
  };
  const char* bytes = text.data() + text.find("end_header\n") + 11;
  mesh.points.resize(count("vertex"));
  for (Point& p : mesh.points) p = take<Point>(bytes);
  mesh.polygons.resize(count("face"));
  for (auto& polygon : mesh.polygons) {
    polygon.resize(take<std::uint8_t>(bytes));
    for (std::uint32_t& i : polygon) i = take<std::uint32_t>(bytes);
  }
  EXPECT_EQ(bytes, text.data() + text.size());
  return mesh;
}

Polygons polygons_of(std::span<const Triangle> triangles) {
  Polygons polygons;
  for (const Triangle& t : triangles) polygons.emplace_back(t.begin(), t.end());
  return polygons;
}

class MeshFile : public testing::Test {
 protected:
  Boundary boundary(const BoxSet& boxes, NonManifold contacts) {
    return find_boundary(unite(boxes, {.device = "native"}), contacts, {});
  }
  bool write(const Boundary& b, const std::string& name, bool triangles_only = false) {
    return write_mesh(b.brep, b.triangulation, triangles_only,
                      open_output(folder_.file(name), FileUse::boundary));
  }
  std::string text(const Boundary& b, const std::string& name, bool triangles_only = false) {
    EXPECT_TRUE(write(b, name, triangles_only));
    return folder_.read(name);
  }
  TemporaryFolder folder_;
};

BoxSet thirds() {
  return std::vector<Box>{
      {0, 0, 0, 1 / 3., 1, 1e-300}, {-1e300, .1, 0, .2, .7, 1e17 / 3}, {.2, .7, 0, 1, 1, 1}};
}

TEST_F(MeshFile, BringsBackEveryPointAndTriangle) {
  for (const BoxSet& boxes :
       {thirds(), BoxSet(collect(generate_sponge(2))), BoxSet(collect(generate_checkerboard(5))),
        BoxSet(collect(generate_cubes(2000, 9, 100, 1))), BoxSet()})
    for (const NonManifold contacts : {NonManifold::keep, NonManifold::split}) {
      const Boundary b = boundary(boxes, contacts);
      const Polygons triangles = polygons_of(b.triangulation.triangles);
      for (const Read& mesh :
           {read_obj(text(b, "a.obj", true)), read_off(text(b, "a.off")), read_ply(text(b, "a.PLY"))}) {
        EXPECT_EQ(mesh.points, b.brep.points);
        EXPECT_EQ(mesh.polygons, triangles);
      }
    }
}

TEST_F(MeshFile, ObjHasThePolygonsOfFacesWithoutHoles) {
  // A tray. Its top is a ring, cut into triangles; each of the other ten faces is a rectangle.
  const BoxSet tray(std::vector<Box>{
      {0, 0, 0, 3, 3, 1}, {0, 0, 1, 1, 3, 2}, {2, 0, 1, 3, 3, 2}, {0, 0, 1, 3, 1, 2}, {0, 2, 1, 3, 3, 2}});
  const Boundary b = boundary(tray, NonManifold::keep);
  EXPECT_EQ(b.brep.faces.size(), 11u);
  EXPECT_EQ(b.brep.faces.holes(), 1u);
  const Read mesh = read_obj(text(b, "a.obj"));
  EXPECT_EQ(mesh.points, b.brep.points);
  std::size_t rectangles = 0, triangles = 0;
  for (const auto& polygon : mesh.polygons) ++(polygon.size() == 4 ? rectangles : triangles);
  EXPECT_EQ(rectangles, 10u);
  EXPECT_EQ(triangles, 8u);
}

TEST_F(MeshFile, StlHasTheTrianglesAndTheirNormals) {
  const Boundary b = boundary(collect(generate_cubes(300, 9, 60, 1)), NonManifold::split);
  const std::string stl = text(b, "a.stl");
  ASSERT_EQ(stl.size(), 84 + 50 * b.triangulation.triangles.size());
  EXPECT_TRUE(stl.starts_with("boxunion"));  // "solid" would mean text
  const char* bytes = stl.data() + 80;
  ASSERT_EQ(take<std::uint32_t>(bytes), b.triangulation.triangles.size());
  for (const Triangle& t : b.triangulation.triangles) {
    const auto normal = take<std::array<float, 3>>(bytes);
    std::array<Point, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = b.brep.points[t[i]];
      for (const double c : p[i]) EXPECT_EQ(take<float>(bytes), float(c));
    }
    EXPECT_EQ(take<std::uint16_t>(bytes), 0);
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t u = (a + 1) % 3, v = (a + 2) % 3;
      const double cross =
          (p[1][u] - p[0][u]) * (p[2][v] - p[0][v]) - (p[1][v] - p[0][v]) * (p[2][u] - p[0][u]);
      EXPECT_EQ(normal[a], float((cross > 0) - (cross < 0)));
    }
  }
}

TEST_F(MeshFile, FloatsThatRoundOrOverflowAreReported) {
  EXPECT_FALSE(write(boundary(std::vector<Box>{{0, 0, 0, .1, 1, 1}}, NonManifold::split), "a.stl"));
  EXPECT_TRUE(write(boundary(std::vector<Box>{{0, 0, 0, .5, 1, 1}}, NonManifold::split), "a.stl"));
  try {
    write(boundary(std::vector<Box>{{0, 0, 0, 1e39, 1, 1}}, NonManifold::split), "b.stl");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    EXPECT_TRUE(std::string(error.what()).ends_with("b.stl: no float holds the coordinate 1e+39"))
        << error.what();
  }
  EXPECT_EQ(folder_.file_count(), 1u);
}

TEST_F(MeshFile, AnInterruptedBoundaryEndsWithAnError) {
  const std::atomic<bool> interrupted = true;
  Options options;
  options.interrupted = &interrupted;
  try {
    find_boundary({}, NonManifold::keep, options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::interrupted);
  }
}

}  // namespace
}  // namespace boxunion

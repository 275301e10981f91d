// The B-rep and its triangles, compared with voxels and the laws of closed surfaces.

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "core/boundary/faces.hpp"
#include "core/boundary/orientation.hpp"
#include "host/files/files.hpp"
#include "tests/boundary/boundary_reference.hpp"
#include "tests/support/generators.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

constexpr NonManifold kBoth[] = {NonManifold::keep, NonManifold::split};

Solid solid_of(const std::vector<IntegerBox>& boxes) {
  return unite(BoxSet(boxes), {.device = "native", .threads = 1});
}

BoundaryCounts counts_of(const Solid& solid, const Brep& brep) {
  BoundaryCounts counts;
  for (const Vertex& v : solid.vertices)
    for (const int direction : {0, 2, 4}) {
      counts.edges += kOctants[v.mask].edges[direction] != 0;
      counts.nonmanifold_edges += kOctants[v.mask].edges[direction] == 2;
    }
  counts.faces = brep.faces.size();
  counts.holes = brep.faces.holes();
  counts.shells = brep.shells.size();
  counts.bodies = brep.shells.bodies;
  return counts;
}

using Step = std::pair<std::uint32_t, std::uint32_t>;

/// Checks that every step along a loop or triangle has its opposite. Returns how often each step occurs.
std::map<Step, int> matched_steps(const std::vector<std::vector<std::uint32_t>>& loops) {
  std::map<Step, int> steps;
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) ++steps[{loop[i], loop[(i + 1) % loop.size()]}];
  for (const auto& [step, times] : steps) {
    EXPECT_NE(step.first, step.second);
    const auto back = steps.find({step.second, step.first});
    if (back == steps.end() || back->second != times) ADD_FAILURE() << "a step without its opposite";
  }
  return steps;
}

std::vector<std::vector<std::uint32_t>> loops_of(const Faces& faces) {
  std::vector<std::vector<std::uint32_t>> loops;
  for (std::size_t l = 0; l < faces.loops(); ++l)
    loops.emplace_back(faces.loop(l).begin(), faces.loop(l).end());
  return loops;
}

std::vector<std::vector<std::uint32_t>> loops_of(std::span<const Triangle> triangles) {
  std::vector<std::vector<std::uint32_t>> loops;
  for (const Triangle& t : triangles) loops.emplace_back(t.begin(), t.end());
  return loops;
}

/// Checks that the faces around every point form one ring.
void expect_one_fan_at_every_point(const std::vector<std::vector<std::uint32_t>>& loops) {
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>>
      after;  // by point: the step in, the step out
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i)
      after[loop[(i + 1) % loop.size()]][loop[i]] = loop[(i + 2) % loop.size()];
  for (const auto& [point, next] : after) {
    std::size_t length = 0;
    for (std::uint32_t at = next.begin()->first; length == 0 || at != next.begin()->first; ++length) {
      if (!next.contains(at) || length > next.size()) {
        ADD_FAILURE() << "an open fan";
        return;
      }
      at = next.at(at);
    }
    EXPECT_EQ(length, next.size()) << "several fans at point " << point;
  }
}

/// Twice the signed area that a loop encloses in its plane, seen from outside. Exact for small multiples of a
/// half.
double doubled_area(std::span<const Point> points, std::span<const std::uint32_t> loop, unsigned direction) {
  const unsigned u = (direction / 2 + 1) % 3, v = (direction / 2 + 2) % 3;
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Point &p = points[loop[i]], &q = points[loop[(i + 1) % loop.size()]];
    sum += p[u] * q[v] - q[u] * p[v];
  }
  return direction % 2 ? -sum : sum;
}

/// Six times the volume enclosed by triangles.
double six_volumes(std::span<const Point> points, std::span<const Triangle> triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) {
    const Point &p = points[t[0]], &q = points[t[1]], &r = points[t[2]];
    sum += p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
           p[2] * (q[0] * r[1] - q[1] * r[0]);
  }
  return sum;
}

Array<Triangle> sorted(Array<Triangle> triangles) {
  std::ranges::sort(triangles);
  return triangles;
}

/// The laws of the boundary of any solid with small integer coordinates.
void expect_laws(const Solid& solid, const Brep& brep, const MassProperties& mass) {
  const Faces& faces = brep.faces;
  const Triangulation triangulation = triangulate(brep.points, faces);
  const auto& triangles = triangulation.triangles;
  ASSERT_EQ(triangles.size(), triangulation.first.back());

  // Faces: triangles of positive area fill them, and lie in their planes.
  std::vector<double> shell_volumes(brep.shells.size());
  double area = 0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const unsigned direction = faces.direction[f], axis = direction / 2;
    double face_area = 0, triangle_area = 0;
    for (std::uint32_t l = faces.first_loop[f]; l < faces.first_loop[f + 1]; ++l) {
      const double loop_area = doubled_area(brep.points, faces.loop(l), direction);
      EXPECT_EQ(loop_area > 0, l == faces.first_loop[f]);
      face_area += loop_area;
    }
    const auto cut = std::span(triangles).subspan(triangulation.first[f],
                                                  triangulation.first[f + 1] - triangulation.first[f]);
    for (const Triangle& t : cut) {
      const double one = doubled_area(brep.points, t, direction);
      EXPECT_GT(one, 0);
      triangle_area += one;
      for (const std::uint32_t p : t)
        EXPECT_EQ(brep.points[p][axis], brep.points[faces.loop(faces.first_loop[f])[0]][axis]);
    }
    EXPECT_EQ(triangle_area, face_area);
    area += face_area / 2;
    shell_volumes[brep.shells.of_face[f]] += six_volumes(brep.points, cut);
  }
  EXPECT_EQ(area, mass.area);
  EXPECT_EQ(six_volumes(brep.points, triangles), 6 * mass.volume);
  std::size_t outer = 0;
  for (std::size_t s = 0; s < brep.shells.size(); ++s) {
    EXPECT_EQ(shell_volumes[s] < 0, bool(brep.shells.cavity[s]));
    outer += !brep.shells.cavity[s];
    EXPECT_LT(brep.shells.body[s], brep.shells.bodies);
  }
  EXPECT_EQ(outer, brep.shells.bodies);

  // Loops run along the edges, triangles around them.
  const auto steps = matched_steps(loops_of(faces));
  std::set<Step> edges;
  for (const Edge& edge : brep.edges) edges.insert({edge[0], edge[1]});
  EXPECT_EQ(edges.size(), brep.edges.size());
  EXPECT_EQ(steps.size(), 2 * edges.size());
  for (const Step& edge : edges) EXPECT_TRUE(steps.contains(edge));
  const auto sides = matched_steps(loops_of(triangles));
  if (brep.contacts == NonManifold::keep) return;

  for (const auto& [step, times] : steps) EXPECT_EQ(times, 1);
  for (const auto& [step, times] : sides) EXPECT_EQ(times, 1);
  expect_one_fan_at_every_point(loops_of(faces));
  expect_one_fan_at_every_point(loops_of(triangles));
  const long euler =
      long(brep.points.size()) - long(brep.edges.size()) + long(faces.size()) - long(faces.holes());
  EXPECT_EQ(euler % 2, 0);
  EXPECT_LE(euler, 2 * long(brep.shells.size()));  // the genus is at least 0
  (void)solid;
}

/// Checks that the B-rep and the voxels agree on the bodies.
void expect_bodies_of(const Voxels& voxels, const Brep& brep) {
  std::map<std::uint32_t, int> names;
  for (std::size_t f = 0; f < brep.faces.size(); ++f) {
    // The face lies right above its first point.
    const Point& p = brep.points[brep.faces.loop(brep.faces.first_loop[f])[0]];
    Voxels::Index voxel = {int(p[0]), int(p[1]), int(p[2])};
    if (brep.faces.direction[f] % 2 == 0) --voxel[brep.faces.direction[f] / 2];
    ASSERT_TRUE(voxels.filled(voxel));
    const auto [name, fresh] =
        names.try_emplace(brep.shells.body[brep.shells.of_face[f]], voxels.body(voxel));
    ASSERT_EQ(name->second, voxels.body(voxel));
  }
  std::set<int> distinct;
  for (const auto& name : names) distinct.insert(name.second);
  ASSERT_EQ(distinct.size(), names.size());
}

void expect_boundary_of(const std::vector<IntegerBox>& boxes) {
  const Solid solid = solid_of(boxes);
  const MassProperties mass = measure(BoxSet(boxes), {.device = "native", .threads = 1});
  const Voxels voxels(boxes);
  const BoundaryCounts expected = voxels.count();
  for (const NonManifold contacts : kBoth) {
    const Brep brep = make_brep(solid, contacts);
    ASSERT_EQ(counts_of(solid, brep), expected);
    expect_bodies_of(voxels, brep);
    expect_laws(solid, brep, mass);
    const Mesh mesh = make_mesh(solid, contacts);
    ASSERT_EQ(mesh.points, brep.points);
    ASSERT_EQ(sorted(mesh.triangles), sorted(triangulate(brep.points, brep.faces).triangles));
  }
}

TEST(Boundary, OfEveryOccupancyOf2x2x3EqualsBruteForce) {
  for (std::uint32_t occupancy = 0; occupancy < 4096; ++occupancy) {
    expect_boundary_of(unit_cubes(occupancy, 2, 2, 3));
    ASSERT_FALSE(HasFailure()) << "occupancy " << occupancy;
  }
}

TEST(Boundary, OfRandomOccupanciesEqualsBruteForce) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1500; ++i) {
    const std::uint64_t thin = i % 3 == 0 ? random() : ~std::uint64_t{0}, thick = i % 3 == 1 ? random() : 0;
    const std::uint64_t occupancy = (random() & thin) | thick;
    expect_boundary_of(i % 2 ? unit_cubes(occupancy, 4, 4, 4) : unit_cubes(occupancy, 3, 7, 3));
    ASSERT_FALSE(HasFailure()) << "case " << i << " occupancy " << occupancy;
  }
}

/// Random voxels of a larger grid: cavities, bodies in cavities, faces with many holes, long loops.
TEST(Boundary, OfRandomVoxelsEqualsBruteForce) {
  std::mt19937 random(2);
  for (const unsigned percent : {5, 20, 40, 60, 75, 85, 97}) {
    std::vector<IntegerBox> boxes;
    for (int z = 0; z < 14; ++z)
      for (int y = 0; y < 13; ++y)
        for (int x = 0; x < 12; ++x)
          if (random() % 100 < percent) boxes.push_back({x, y, z, x + 1, y + 1, z + 1});
    expect_boundary_of(boxes);
    ASSERT_FALSE(HasFailure()) << percent << " percent";
  }
}

/// The six walls of a box, two thick.
void add_hollow_box(std::vector<IntegerBox>& boxes, const std::array<int, 3>& at, int size) {
  for (std::size_t a = 0; a < 3; ++a)
    for (const int side : {0, size - 2}) {
      IntegerBox wall = {at[0], at[1], at[2], at[0] + size, at[1] + size, at[2] + size};
      wall[a] += side;
      wall[a + 3] = wall[a] + 2;
      boxes.push_back(wall);
    }
}

TEST(Boundary, NestedShellsBelongToTheirBodies) {
  std::vector<IntegerBox> boxes;
  for (int i = 0; i < 4; ++i)
    for (int depth = 0; depth <= i; ++depth)
      add_hollow_box(boxes, {24 * i + 3 * depth, 3 * depth, 3 * depth}, 22 - 6 * depth);
  expect_boundary_of(boxes);
  const Brep brep = make_brep(solid_of(boxes), NonManifold::keep);
  EXPECT_EQ(brep.shells.bodies, 10u);
  EXPECT_EQ(brep.shells.cavities(), 10u - 1u);  // the innermost of four is solid
}

TEST(Boundary, OfNothingIsEmpty) {
  for (const NonManifold contacts : kBoth) {
    const Brep brep = make_brep({}, contacts);
    EXPECT_EQ(
        brep.points.size() + brep.edges.size() + brep.faces.size() + brep.faces.loops() + brep.shells.size(),
        0u);
    EXPECT_TRUE(make_mesh({}, contacts).triangles.empty());
  }
}

TEST(Boundary, ThreadsNeverChangeIt) {
  const std::vector<IntegerBox> boxes = collect(generate_cubes(3000, 8, 100, 5));
  const Solid solid = solid_of(boxes);
  for (const NonManifold contacts : kBoth) {
    Brep expected;
    Mesh expected_mesh;
    tbb::task_arena(1).execute([&] {
      expected = make_brep(solid, contacts);
      expected_mesh = make_mesh(solid, contacts);
    });
    for (const int threads : {2, 8})
      tbb::task_arena(threads).execute([&] {
        const Brep brep = make_brep(solid, contacts);
        EXPECT_EQ(brep.points, expected.points);
        EXPECT_EQ(brep.edges, expected.edges);
        EXPECT_EQ(brep.faces.loop_points, expected.faces.loop_points);
        EXPECT_EQ(brep.faces.first_point, expected.faces.first_point);
        EXPECT_EQ(brep.faces.first_loop, expected.faces.first_loop);
        EXPECT_EQ(brep.faces.direction, expected.faces.direction);
        EXPECT_EQ(brep.shells.of_face, expected.shells.of_face);
        EXPECT_EQ(brep.shells.body, expected.shells.body);
        const Mesh mesh = make_mesh(solid, contacts);
        EXPECT_EQ(mesh.points, expected_mesh.points);
        EXPECT_EQ(mesh.triangles, expected_mesh.triangles);
        EXPECT_EQ(triangulate(brep.points, brep.faces).triangles,
                  triangulate(expected.points, expected.faces).triangles);
      });
  }
}

void expect_counts(const BoxSet& boxes, const BoundaryCounts& expected) {
  const Solid solid = unite(boxes, {.device = "native"});
  for (const NonManifold contacts : kBoth) {
    const Brep brep = make_brep(solid, contacts);
    EXPECT_EQ(counts_of(solid, brep), expected);
    const auto loops = loops_of(triangulate(brep.points, brep.faces).triangles);
    matched_steps(loops);
    if (contacts == NonManifold::split) expect_one_fan_at_every_point(loops);
  }
}

TEST(Boundary, OfKnownSolids) {
  // The genus is 1409: 7912 - 16920 + 7326 - 1134 = 2 - 2 * 1409.
  expect_counts(collect(generate_sponge(3)), {16920, 0, 7326, 1134, 1, 1});
  expect_counts(collect(generate_checkerboard(20)), {26340, 21660, 24000, 0, 4000, 4000});
}

TEST(Boundary, OfStandardCells) {
  const std::string path = BOXUNION_DATA "/sky130_hd_row.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path << "; see BOXUNION_DATA";
  expect_counts(read_boxes(path), {176540, 0, 66517, 897, 3432, 3432});
}

/// Sums in rational numbers over the doubles of a mesh.
MassProperties mass_of(const Mesh& mesh) {
  mpq_class six_volumes, doubled_area;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<mpq_class, 3>, 3> p;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t a = 0; a < 3; ++a) p[i][a] = mesh.points[t[i]][a];
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
      six_volumes += p[0][a] * (p[1][b] * p[2][c] - p[1][c] * p[2][b]);
      doubled_area +=
          abs((p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]));
    }
  }
  MassProperties mass;
  mass.volume = round_to_nearest(six_volumes / 6);
  mass.area = round_to_nearest(doubled_area / 2);
  return mass;
}

void expect_mass_of_meshes(const std::vector<Box>& boxes) {
  const MassProperties mass = measure(boxes, {.device = "native", .threads = 1});
  const Solid solid = unite(boxes, {.device = "native", .threads = 1});
  for (const NonManifold contacts : kBoth) {
    const Mesh mesh = make_mesh(solid, contacts);
    const MassProperties found = mass_of(mesh);
    RC_ASSERT(found.volume == mass.volume);
    RC_ASSERT(found.area == mass.area);
    for (const auto& [step, times] : matched_steps(loops_of(mesh.triangles)))
      RC_ASSERT(contacts == NonManifold::keep || times == 1);
  }
}

TEST(BoundaryProperty, MeshesHaveTheMassOfTheirBoxes) {
  EXPECT_TRUE(
      rc::check("decimal coordinates", [] { expect_mass_of_meshes(*boxes_from(decimal(), 12, 14)); }));
  EXPECT_TRUE(rc::check("coordinates of every size",
                        [] { expect_mass_of_meshes(*boxes_from(nasty_coordinate(), 9, 9)); }));
}

TEST(Orientation, IsExactForAllDoubles) {
  const auto exact = [](const auto& a, const auto& b, const auto& c) {
    const auto minus = [](double p, double q) { return mpq_class(mpq_class(p) - mpq_class(q)); };
    return sgn(mpq_class(minus(b[0], a[0]) * minus(c[1], a[1]) - minus(b[1], a[1]) * minus(c[0], a[0])));
  };
  const auto agrees = [&](const rc::Gen<double>& coordinate) {
    const auto a = *rc::gen::container<std::array<double, 2>>(coordinate);
    const auto b = *rc::gen::container<std::array<double, 2>>(coordinate);
    auto c = *rc::gen::container<std::array<double, 2>>(coordinate);
    RC_ASSERT(orientation(a, b, c) == exact(a, b, c));
    const double along = *rc::gen::element(-1.0, 0.5, 2.0, 1 / 3., 0.1);
    c = {a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1])};  // collinear or nearly so
    if (std::isfinite(c[0]) && std::isfinite(c[1])) RC_ASSERT(orientation(a, b, c) == exact(a, b, c));
  };
  EXPECT_TRUE(rc::check("decimals", [&] { agrees(decimal()); }));
  EXPECT_TRUE(rc::check("small integers", [&] { agrees(small_integer()); }));
  EXPECT_TRUE(rc::check("nasty coordinates", [&] { agrees(nasty_coordinate()); }));
  EXPECT_TRUE(rc::check("any doubles", [&] { agrees(rc::gen::arbitrary<double>()); }));
}

TEST(Boundary, AnEdgeWithoutRoomForAMidpointCannotBeSplit) {
  // Class 00000110 with six filled octants, one step of a double high. Both copies of its edge would join the
  // same fans.
  const double next = std::nextafter(1.0, 2.0);
  std::vector<Box> boxes;
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 1}})
    boxes.push_back({double(x), double(y), 1, x + 1.0, y + 1.0, next});
  for (const auto& [lo, hi] : {std::pair{0.0, 1.0}, {next, 3.0}}) boxes.push_back({0, 0, lo, 2, 2, hi});
  const Solid solid = unite(boxes, {.device = "native"});
  EXPECT_NO_THROW(make_mesh(solid, NonManifold::keep));
  try {
    make_mesh(solid, NonManifold::split);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
  }
}

}  // namespace
}  // namespace boxunion

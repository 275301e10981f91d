// Times the way from boxes in memory to a B-rep and to a watertight triangle mesh, natively, over the peers'
// input: identical cubes at integer positions (see README.md). Each mesh is checked before it is timed.
// Prints a Markdown table; times are medians, in seconds.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "bench/sorting.hpp"
#include "bench/table.hpp"
#include "bench/timing.hpp"
#include "core/brep.hpp"
#include "core/generate.hpp"
#include "core/triangulation.hpp"
#include "host/engine.hpp"

namespace {

using namespace boxunion;

constexpr int kUniverse = 32768;
constexpr std::size_t kSparseOnly = 1'000'000;  // so many cubes and more
const Options kOptions{.device = "native"};

/// Cubes of which the volumes add up to `volumes` universes, with low corners uniform on [0, kUniverse).
BoxSet cubes(std::size_t count, double volumes) {
  const auto edge = std::lround(kUniverse * std::cbrt(volumes / double(count)));
  return collect(generate_cubes(count, edge, kUniverse - 1 + edge, 12345));
}

/// Is every edge of the triangles matched by its opposite, and their volume that of the boxes?
bool is_right(const Mesh& mesh, const MassProperties& mass) {
  std::vector<std::uint64_t> sides;
  long double six_volumes = 0;
  for (const Triangle& t : mesh.triangles) {
    const Point &p = mesh.points[t[0]], &q = mesh.points[t[1]], &r = mesh.points[t[2]];
    six_volumes += static_cast<long double>(p[0]) * (q[1] * r[2] - q[2] * r[1]) +
                   p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0]);
    for (unsigned i = 0; i < 3; ++i) sides.push_back(std::uint64_t{t[i]} << 32 | t[(i + 1) % 3]);
  }
  std::vector<std::uint64_t> opposite(sides.size());
  std::transform(sides.begin(), sides.end(), opposite.begin(),
                 [](std::uint64_t s) { return s << 32 | s >> 32; });
  std::sort(sides.begin(), sides.end());
  std::sort(opposite.begin(), opposite.end());
  return sides == opposite && std::abs(double(six_volumes) / 6 - mass.volume) <= 1e-12 * mass.volume;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Times the way from boxes in memory to a B-rep and to a watertight triangle mesh.");
  Tables tables(app);
  int runs = 5;
  std::vector<std::size_t> counts = {1000, 10'000, 100'000, kSparseOnly};
  app.add_option("runs", runs, "Runs of which the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("cubes", counts, "Numbers of cubes; from 1000000 on only sparse ones")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000'000}))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  tables.begin("boundary", {"cubes", "volumes", "vertices", "faces", "triangles", "sort", "union", "brep",
                            "mesh", "split_mesh"});
  for (const std::size_t count : counts)
    for (const double volumes : {0.015, 0.5, 3.0}) {
      if (count >= kSparseOnly && volumes > 0.015) continue;
      const BoxSet boxes = cubes(count, volumes);
      const Solid solid = unite(boxes, kOptions);
      const MassProperties mass = measure(boxes, kOptions);
      const std::size_t faces = make_brep(solid, NonManifold::keep).faces.size();
      std::size_t triangles = 0;
      const auto is_right_kept = [&] {
        const Mesh mesh = make_mesh(solid, NonManifold::keep);
        triangles = mesh.triangles.size();
        return is_right(mesh, mass);
      };
      if (!is_right_kept() || !is_right(make_mesh(solid, NonManifold::split), mass)) {
        fmt::print("{} cubes of volume {}: wrong mesh\n", count, volumes);
        return 1;
      }
      std::array<std::vector<double>, 5> times;
      for (int r = 0; r < runs; ++r) {  // in turn, so that all see the same machine
        times[0].push_back(seconds_to_sort(boxes));
        times[1].push_back(seconds_of([&] { unite(boxes, kOptions); }));
        times[2].push_back(seconds_of([&] { make_brep(unite(boxes, kOptions), NonManifold::keep); }));
        times[3].push_back(seconds_of([&] { make_mesh(unite(boxes, kOptions), NonManifold::keep); }));
        times[4].push_back(seconds_of([&] { make_mesh(unite(boxes, kOptions), NonManifold::split); }));
      }
      tables.add(count, volumes, solid.vertices.size(), faces, triangles, median(times[0]), median(times[1]),
                 median(times[2]), median(times[3]), median(times[4]));
    }
  tables.write();
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}

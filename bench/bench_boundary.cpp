// Times the way from boxes in memory to a B-rep and to a watertight triangle mesh, natively, on the input of
// the peers: identical cubes at integer positions (see README.md). Each mesh is checked before it is timed.
// Prints a Markdown table. Times are medians, in seconds.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/program.hpp"
#include "bench/sorting.hpp"
#include "bench/timing.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "core/boundary/faces.hpp"

namespace {

using namespace boxunion;

constexpr int kUniverse = 32768;
constexpr std::size_t kSparseOnly = 1'000'000;  // from so many cubes on
const Options kOptions{.device = "native"};

/// Cubes whose volumes add up to `volumes` universes, with low corners uniform on [0, kUniverse).
BoxSet cubes(std::size_t count, double volumes) {
  const auto edge = std::lround(kUniverse * std::cbrt(volumes / double(count)));
  return collect(generate_cubes(count, edge, kUniverse - 1 + edge, 12345));
}

/// True if every edge of the triangles has its opposite, and their volume is that of the boxes.
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

void run(const Request& request, Tables& tables) {
  tables.begin("boundary", {"cubes", "volumes", "vertices", "faces", "triangles", "sort", "union", "brep",
                            "mesh", "split_mesh"});
  for (const std::size_t count : request.counts)
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
      if (!is_right_kept() || !is_right(make_mesh(solid, NonManifold::split), mass))
        throw std::runtime_error(fmt::format("{} cubes of volume {}: wrong mesh", count, volumes));
      std::array<std::vector<double>, 5> times;
      for (int r = 0; r < request.runs; ++r) {  // in turn, so that all run under the same conditions
        times[0].push_back(seconds_to_sort(boxes));
        times[1].push_back(seconds_of([&] { unite(boxes, kOptions); }));
        times[2].push_back(seconds_of([&] { make_brep(unite(boxes, kOptions), NonManifold::keep); }));
        times[3].push_back(seconds_of([&] { make_mesh(unite(boxes, kOptions), NonManifold::keep); }));
        times[4].push_back(seconds_of([&] { make_mesh(unite(boxes, kOptions), NonManifold::split); }));
      }
      tables.add(count, volumes, solid.vertices.size(), faces, triangles, median(times[0]), median(times[1]),
                 median(times[2]), median(times[3]), median(times[4]));
    }
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmark(
      argc, argv,
      "Times the way from boxes in memory to a B-rep and to a watertight triangle mesh: all densities up "
      "to 100000 cubes, sparse ones beyond.",
      {.counts = {1000, 10'000, 100'000, kSparseOnly}, .sections = {}}, run);
}

// Boxes from any bytes: every method, kernel and cell size finds the same union, and its boundary is closed.

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "boxunion/mesh.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/mass_sink.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace boxunion::fuzz {
namespace {

Options way(Method method, CellKernel kernel, const Tuning& tuning) {
  Options options = native();
  options.method = method;
  options.kernel = kernel;
  options.tuning = tuning;
  return options;
}

const std::array kWays = {native(),
                          way(Method::cells, CellKernel::occupancy, {.cell = 1}),
                          way(Method::cells, CellKernel::occupancy, {.cell = 4}),
                          way(Method::cells, CellKernel::occupancy, {.cell_boxes = 1}),
                          way(Method::cells, CellKernel::faces, {}),
                          way(Method::cells, CellKernel::faces, {.cell = 3}),
                          way(Method::slices, {}, {}),
                          way(Method::slices, {}, {.tile_coordinates = 2})};

/// Checks that each side of a triangle occurs as often as its opposite, and only once if contacts are split.
void expect_closed(const Mesh& mesh, NonManifold contacts) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++sides[{t[i], t[(i + 1) % 3]}];
  for (const auto& [side, times] : sides) {
    const auto back = sides.find({side.second, side.first});
    expect(side.first != side.second && back != sides.end() && back->second == times);
    expect(contacts == NonManifold::keep || times == 1);
  }
}

double six_volumes(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const Point &p = mesh.points[t[0]], &q = mesh.points[t[1]], &r = mesh.points[t[2]];
    sum += p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
           p[2] * (q[0] * r[1] - q[1] * r[0]);
  }
  return sum;
}

/// Checks that each coordinate maps to an ordinal and back, also if a row that fills the first block of the
/// scan comes first.
void expect_exact_axes(const BoxSet& boxes) {
  if (boxes.size() == 0) return;
  std::vector<Box> rows(128, boxes[0]);
  for (std::size_t i = 0; i < boxes.size(); ++i) rows.push_back(boxes[i]);
  const Axes axes = make_axes(rows);
  for (const Box& row : rows)
    for (unsigned c = 0; c < 6; ++c) {
      const Axis& axis = axes[c % 3];
      expect(axis.coordinate(axis.ordinal(row[c])) == row[c]);
    }
}

void check(const BoxSet& boxes, const Options& options) {
  expect_exact_axes(boxes);
  const Solid solid = unite(boxes, native());
  const MassProperties mass = measure(boxes, options);
  MassSink sink(solid.axes);
  sink.add(solid.vertices);
  expect(mass == sink.result());
  expect(unite(boxes, options).vertices == solid.vertices);
  const bool is_integer =
      boxes.visit([]<class T>(const std::vector<BoxOf<T>>&) { return std::is_same_v<T, std::int32_t>; });
  for (const NonManifold contacts : {NonManifold::keep, NonManifold::split}) {
    const Mesh mesh = make_mesh(solid, contacts);
    expect_closed(mesh, contacts);
    if (is_integer) expect(six_volumes(mesh) == 6 * mass.volume);
  }
}

}  // namespace
}  // namespace boxunion::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace boxunion::fuzz;
  Bytes input(bytes, count);
  const boxunion::Options options = input.one_of(kWays);
  const int range = 1 + input.below(40);
  check(take_box_set(input, 48, range), options);
  return 0;
}

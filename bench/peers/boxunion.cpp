// Our side of every comparison:
//
//   peer_boxunion TASK FILE [DEVICE]    tasks: measure brep mesh contour loops voxels labels6 labels26
//
// Natively unless a device is given. See contender.hpp; bench/peers/run says what each task is compared with.

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "bench/peers/contender.hpp"
#include "boxunion/contour.hpp"
#include "boxunion/files.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "boxunion/voxels.hpp"
#include "core/boundary/faces.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/files/files.hpp"

namespace boxunion::peers {
namespace {

using nlohmann::json;

const std::string kVersion = "boxunion";

/// The vector area of a closed polygon, given its corners; see add().
std::array<double, 3> vector_area(std::span<const Point> points, std::span<const std::uint32_t> loop) {
  std::array<double, 3> sum{};
  const Point& o = points[loop[0]];
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    const Point &p = points[loop[i]], &q = points[loop[i + 1]];
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
      sum[a] += ((p[b] - o[b]) * (q[c] - o[c]) - (p[c] - o[c]) * (q[b] - o[b])) / 2;
    }
  }
  return sum;
}

/// Volume and area, computed from the surface itself as a check.
struct Surface {
  double three_volumes = 0, area = 0;
  /// Adds a polygon seen counter-clockwise from outside, or (area < 0) a hole in one.
  void add(const Point& corner, const std::array<double, 3>& vector, double area_of_it) {
    three_volumes += corner[0] * vector[0] + corner[1] * vector[1] + corner[2] * vector[2];
    area += area_of_it;
  }
  double volume() const { return three_volumes / 3; }
};

json describe(const MassProperties& mass) {
  return {{"volume", mass.volume}, {"area", mass.area}, {"vertices", mass.vertices}};
}

json describe(const Brep& brep) {
  Surface surface;
  for (std::size_t f = 0; f < brep.faces.size(); ++f) {
    const std::size_t axis = brep.faces.direction[f] / 2u;
    const double outward = brep.faces.direction[f] % 2 == 0 ? 1 : -1;
    for (std::size_t l = brep.faces.first_loop[f]; l < brep.faces.first_loop[f + 1]; ++l) {
      const auto vector = vector_area(brep.points, brep.faces.loop(l));
      surface.add(brep.points[brep.faces.loop(l)[0]], vector, outward * vector[axis]);
    }
  }
  return {{"volume", surface.volume()},  {"area", surface.area},       {"vertices", brep.points.size()},
          {"edges", brep.edges.size()},  {"faces", brep.faces.size()}, {"holes", brep.faces.holes()},
          {"shells", brep.shells.size()}};
}

json describe(const Mesh& mesh) {
  Surface surface;
  for (const Triangle& t : mesh.triangles) {
    const auto vector = vector_area(mesh.points, t);
    surface.add(mesh.points[t[0]], vector, std::hypot(vector[0], vector[1], vector[2]));
  }
  return {{"volume", surface.volume()},
          {"area", surface.area},
          {"points", mesh.points.size()},
          {"triangles", mesh.triangles.size()}};
}

/// Describes the corners of the union of squares, with their quadrants.
json describe(const Contour& contour) {
  double area = 0;
  std::uint64_t corners = 0;
  for (const ContourVertex& v : contour.vertices) {
    int weight = 0;
    for (unsigned q = 0; q < 4; ++q)
      if (v.quadrants >> q & 1u) weight += q == 0 || q == 3 ? 1 : -1;
    const auto [x, y] = contour.position(v);
    area += weight * x * y;
    corners += weight % 2 == 0 ? 2 : 1;  // two of them touch
  }
  return {{"area", area}, {"corners", corners}};
}

/// The union of squares as polygons with holes.
struct Polygons {
  Contour contour;
  Faces faces;
};
json describe(const Polygons& polygons) {
  const Faces& faces = polygons.faces;
  double area = 0;
  for (std::size_t l = 0; l < faces.loops(); ++l) {
    const auto loop = faces.loop(l);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto [px, py] = polygons.contour.position(polygons.contour.vertices[loop[i]]);
      const auto [qx, qy] = polygons.contour.position(polygons.contour.vertices[loop[(i + 1) % loop.size()]]);
      area += (px * qy - qx * py) / 2;
    }
  }
  return {{"area", area},
          {"corners", faces.loop_points.size()},
          {"polygons", faces.size()},
          {"holes", faces.holes()}};
}

struct Voxels {
  MassProperties mass;
  std::size_t components6 = 0, components26 = 0;
};
json describe(const Voxels& voxels) {
  return {{"volume", voxels.mass.volume},
          {"area", voxels.mass.area},
          {"extreme_vertices", voxels.mass.extreme_vertices},
          {"components_6", voxels.components6},
          {"components_26", voxels.components26}};
}

struct VoxelLabels {
  Array<std::uint32_t> labels;
  std::size_t components = 0;
};
/// The checksum is over labels numbered in the order of their first voxels, as ours are: the sum of label *
/// (2 * index + 1), modulo 2^64.
json describe(const VoxelLabels& result) {
  std::uint64_t checksum = 0;
  for (std::uint64_t i = 0; i < result.labels.size(); ++i) checksum += result.labels[i] * (2 * i + 1);
  return {{"components", result.components}, {"checksum", checksum}};
}

VoxelLabels labels_of(const Volume& volume, Connectivity connectivity) {
  VoxelLabels result;
  result.labels.resize(volume.inside.size());
  result.components = label_voxels(volume, connectivity, result.labels).size();
  return result;
}

/// The x and y of boxes.
RectangleSet bases(const BoxSet& set) {
  return set.visit([]<class T>(const std::vector<BoxOf<T>>& boxes) -> RectangleSet {
    std::vector<RectangleOf<T>> rectangles;
    for (const BoxOf<T>& b : boxes) rectangles.push_back({b[0], b[1], b[3], b[4]});
    return rectangles;
  });
}

void take_part(const std::string& task, const std::string& file, const Options& options) {
  const auto run = [](auto&& compute) {
    peers::contend(kVersion, compute, [](const auto& result) { return describe(result); });
  };
  if (is_volume(file)) {
    const Volume volume = read_volume(file);
    if (task == "voxels")
      return run([&] {
        return Voxels{measure(voxel_boxes(stream_of(volume)), options),
                      labels_of(volume, Connectivity::faces).components,
                      labels_of(volume, Connectivity::points).components};
      });
    if (task == "labels6") return run([&] { return labels_of(volume, Connectivity::faces); });
    if (task == "labels26") return run([&] { return labels_of(volume, Connectivity::points); });
  } else {
    const BoxSet boxes = read_boxes(file);
    if (task == "measure") return run([&] { return measure(boxes, options); });
    if (task == "brep") return run([&] { return make_brep(unite(boxes, options), NonManifold::keep); });
    if (task == "mesh") return run([&] { return make_mesh(unite(boxes, options), NonManifold::keep); });
    if (task == "contour" || task == "loops") {
      const RectangleSet rectangles = bases(boxes);
      if (task == "contour") return run([&] { return find_contour(rectangles); });
      return run([&] {
        Polygons polygons{find_contour(rectangles), {}};
        polygons.faces = find_polygons(polygons.contour);
        return polygons;
      });
    }
  }
  throw Error(ErrorKind::usage, "no such task for " + file + ": " + task);
}

}  // namespace
}  // namespace boxunion::peers

int main(int argc, char** argv) try {
  using namespace boxunion;
  if (argc != 3 && argc != 4) throw Error(ErrorKind::usage, "expected TASK FILE [DEVICE]");
  peers::take_part(argv[1], argv[2], {.device = argc == 4 ? argv[3] : "native"});
  return 0;
} catch (const boxunion::Error& e) {
  std::cerr << e.what() << '\n';
  return int(e.kind());
}

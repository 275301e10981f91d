// CGAL: the union of boxes as triangle meshes, by corefinement of pairs in a tree, with exact constructions.
//
//   peer_cgal_corefinement FILE

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/generators.h>
#include <CGAL/version.h>

#include "bench/peers/contender.hpp"
#include "host/files/files.hpp"

namespace {

namespace processing = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

Mesh cuboid(const boxunion::Box& b) {
  const Kernel::Iso_cuboid_3 box(Point(b[0], b[1], b[2]), Point(b[3], b[4], b[5]));
  Mesh mesh;
  CGAL::make_hexahedron(box[0], box[1], box[2], box[3], box[4], box[5], box[6], box[7], mesh);
  processing::triangulate_faces(mesh);
  return mesh;
}

Mesh unite(const boxunion::BoxSet& boxes, std::size_t first, std::size_t last) {
  if (last == first) return {};
  if (last - first == 1) return cuboid(boxes[first]);
  Mesh left = unite(boxes, first, (first + last) / 2), right = unite(boxes, (first + last) / 2, last), both;
  if (!processing::corefine_and_compute_union(left, right, both))
    throw std::runtime_error("the union of two parts is no manifold, which corefinement cannot represent");
  return both;
}

nlohmann::json describe(const Mesh& mesh) {
  return {{"volume", CGAL::to_double(processing::volume(mesh))},
          {"area", CGAL::to_double(processing::area(mesh))},
          {"triangles", mesh.number_of_faces()}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("expected FILE");
  const boxunion::BoxSet boxes = boxunion::read_boxes(argv[1]);
  boxunion::peers::contend(
      "CGAL " CGAL_VERSION_STR " corefinement", [&] { return unite(boxes, 0, boxes.size()); }, describe);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}

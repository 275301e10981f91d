// CGAL: the union of boxes as Nef polyhedra, with exact constructions.
//
//   peer_cgal_nef FILE

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Nef_3/SNC_indexed_items.h>
#include <CGAL/Nef_nary_union_3.h>
#include <CGAL/Nef_polyhedron_3.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polyhedron_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/convert_nef_polyhedron_to_polygon_mesh.h>
#include <CGAL/boost/graph/generators.h>
#include <CGAL/version.h>

#include "bench/peers/contender.hpp"
#include "host/files.hpp"

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Point = Kernel::Point_3;
using Nef = CGAL::Nef_polyhedron_3<Kernel, CGAL::SNC_indexed_items>;

Nef cuboid(const boxunion::Box& b) {
  const Kernel::Iso_cuboid_3 box(Point(b[0], b[1], b[2]), Point(b[3], b[4], b[5]));
  CGAL::Polyhedron_3<Kernel> hexahedron;
  CGAL::make_hexahedron(box[0], box[1], box[2], box[3], box[4], box[5], box[6], box[7], hexahedron);
  return Nef(hexahedron);
}

Nef unite(const boxunion::BoxSet& boxes) {
  CGAL::Nef_nary_union_3<Nef> unions;
  for (std::size_t i = 0; i < boxes.size(); ++i) unions.add_polyhedron(cuboid(boxes[i]));
  return unions.get_union();
}

nlohmann::json describe(const Nef& nef) {
  CGAL::Surface_mesh<Point> mesh;
  CGAL::convert_nef_polyhedron_to_polygon_mesh(nef, mesh, true);
  namespace measures = CGAL::Polygon_mesh_processing;
  return {{"volume", CGAL::to_double(measures::volume(mesh))},
          {"area", CGAL::to_double(measures::area(mesh))},
          {"vertices", nef.number_of_vertices()},
          {"edges", nef.number_of_edges()},
          {"faces", nef.number_of_facets()},
          {"volumes", nef.number_of_volumes()}};  // the outside is one
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("expected FILE");
  const boxunion::BoxSet boxes = boxunion::read_boxes(argv[1]);
  boxunion::peers::contend(
      "CGAL " CGAL_VERSION_STR " Nef_polyhedron_3", [&] { return unite(boxes); }, describe);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}

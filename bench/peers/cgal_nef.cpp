// CGAL: the union of boxes as Nef polyhedra, with exact constructions.
//
//   peer_cgal_nef FILE

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Nef_3/SNC_indexed_items.h>
#include <CGAL/Nef_nary_union_3.h>
#include <CGAL/Nef_polyhedron_3.h>
#include <CGAL/Polyhedron_3.h>
#include <CGAL/boost/graph/generators.h>
#include <CGAL/version.h>

#include "bench/peers/contender.hpp"
#include "host/files/files.hpp"

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

using Vector = Kernel::Vector_3;

/// The vector area of a facet, pointing outwards, and the volume of the pyramid from it to the origin.
struct Pyramid {
  Vector area{CGAL::NULL_VECTOR};
  Kernel::FT six_volumes = 0;
};

Pyramid pyramid_of(Nef::Halffacet_const_handle facet) {
  Pyramid sum;
  const Vector origin_to_plane = facet->plane().point() - CGAL::ORIGIN;
  for (auto cycle = facet->facet_cycles_begin(); cycle != facet->facet_cycles_end(); ++cycle) {
    if (!cycle.is_shalfedge()) continue;
    const Nef::SHalfedge_around_facet_const_circulator first(Nef::SHalfedge_const_handle{cycle});
    auto corner = first;
    do {
      const Point& p = corner->source()->source()->point();
      const Point& q = corner->next()->source()->source()->point();
      sum.area = sum.area + CGAL::cross_product(p - CGAL::ORIGIN, q - CGAL::ORIGIN) / 2;
    } while (++corner != first);
  }
  sum.six_volumes = 2 * (origin_to_plane * sum.area);
  return sum;
}

/// Measures the facets themselves: a polyhedron that is converted to a mesh loses volume at non-manifold
/// edges.
nlohmann::json describe(const Nef& nef) {
  Kernel::FT six_volumes = 0, area = 0;
  for (auto facet = nef.halffacets_begin(); facet != nef.halffacets_end(); ++facet) {
    if (facet->incident_volume()->mark()) continue;  // the other half of the facet points outwards
    const Pyramid pyramid = pyramid_of(facet);
    six_volumes += pyramid.six_volumes;
    area += CGAL::abs(pyramid.area.x()) + CGAL::abs(pyramid.area.y()) + CGAL::abs(pyramid.area.z());
  }
  return {{"volume", CGAL::to_double(CGAL::abs(six_volumes)) / 6},
          {"area", CGAL::to_double(area)},
          {"vertices", nef.number_of_vertices()},
          {"edges", nef.number_of_edges()},
          {"faces", nef.number_of_facets()},
          {"shells", nef.number_of_volumes() - 1}};  // each shell bounds one volume more than the outside
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

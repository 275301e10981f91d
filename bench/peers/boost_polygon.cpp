// Boost.Polygon: the union of squares, the x and y of boxes, by polygon_90_set_data.
//
//   peer_boost_polygon contour|loops FILE
//
// contour: the edges of the union, in the form in which the library keeps a set. loops: polygons with holes.

#include <boost/polygon/polygon.hpp>
#include <boost/version.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "bench/peers/contender.hpp"
#include "host/files/files.hpp"

namespace {

using namespace boost::polygon;
using namespace boost::polygon::operators;
using Coordinate = int;
using Set = polygon_90_set_data<Coordinate>;
using Polygon = polygon_90_with_holes_data<Coordinate>;
using Rectangles = std::vector<rectangle_data<Coordinate>>;

Rectangles read_rectangles(const std::string& file) {
  const boxunion::BoxSet boxes = boxunion::read_boxes(file);
  Rectangles rectangles;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const boxunion::Box b = boxes[i];
    rectangles.emplace_back(Coordinate(b[0]), Coordinate(b[1]), Coordinate(b[3]), Coordinate(b[4]));
  }
  return rectangles;
}

Set unite(const Rectangles& rectangles) {
  Set set;
  for (const auto& rectangle : rectangles) set.insert(rectangle);
  set.clean();
  return set;
}

std::vector<Polygon> polygons_of(const Set& set) {
  std::vector<Polygon> polygons;
  set.get(polygons);
  return polygons;
}

nlohmann::json describe(const std::vector<Polygon>& polygons) {
  double area_sum = 0;
  std::size_t corners = 0, holes = 0;
  for (const Polygon& polygon : polygons) {
    area_sum += double(area(polygon));
    corners += polygon.size();
    for (auto hole = polygon.begin_holes(); hole != polygon.end_holes(); ++hole, ++holes)
      corners += hole->size();
  }
  return {{"area", area_sum}, {"corners", corners}, {"polygons", polygons.size()}, {"holes", holes}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("expected contour|loops FILE");
  const Rectangles rectangles = read_rectangles(argv[2]);
  const std::string version = "Boost.Polygon " BOOST_LIB_VERSION;
  if (std::string(argv[1]) == "contour")
    boxunion::peers::contend(
        version, [&] { return unite(rectangles); },
        [](const Set& set) {
          nlohmann::json all = describe(polygons_of(set));
          return nlohmann::json{{"area", all["area"]}, {"corners", all["corners"]}};
        });
  else
    boxunion::peers::contend(
        version, [&] { return polygons_of(unite(rectangles)); }, describe);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}

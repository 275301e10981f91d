#include <boxunion/boxunion.hpp>
#include <cstdio>

int main() {
  const boxunion::BoxSet boxes(std::vector<boxunion::Box>{{0, 0, 0, 2, 2, 2}, {1, 1, 1, 3, 3, 3}});
  boxunion::Report report;
  const boxunion::MassProperties mass = boxunion::measure(boxes, {.device = "auto"}, &report);
  std::printf("volume %g, area %g, %zu vertices by %s\n", mass.volume, mass.area, std::size_t(mass.vertices),
              report.device.c_str());

  const boxunion::Solid solid = boxunion::unite(boxes, {});
  for (const boxunion::Vertex& v : solid.vertices)
    std::printf("%g %g %g\n", solid.axes[0].coordinate(v.x), solid.axes[1].coordinate(v.y),
                solid.axes[2].coordinate(v.z));
}

#include "boxunion/union.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/engine/threads.hpp"

namespace boxunion {

Boundary find_boundary(const Solid& solid, NonManifold contacts, const Options& options, Report* report) {
  Report own;
  Report& r = report ? *report : own;
  Boundary boundary;
  Stages stages(r);
  constexpr double kStages = 6;  // of make_brep, and triangles
  int finished = 0;
  const auto finish = [&](std::string_view stage) {
    stages.finish(stage);
    if (options.progress) options.progress(++finished / kStages);
  };
  with_threads(options, [&] {
    boundary.brep = make_brep(solid, contacts, finish);
    boundary.triangulation = triangulate(boundary.brep.points, boundary.brep.faces);
    finish("triangles");
  });
  stages.end();
  return boundary;
}

}  // namespace boxunion

#include "host/boundary.hpp"

#include <tbb/task_arena.h>

#include "host/stopwatch.hpp"

namespace boxunion {

Boundary find_boundary(const Solid& solid, NonManifold contacts, const Options& options, Report* report) {
  Report own;
  Report& r = report ? *report : own;
  Boundary boundary;
  Stages stages(r, options.interrupted);
  const auto finish = [&](std::string_view stage) { stages.finish(stage); };
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    boundary.brep = make_brep(solid, contacts, finish);
    boundary.triangulation = triangulate(boundary.brep.points, boundary.brep.faces);
    finish("triangles");
  });
  stages.end();
  return boundary;
}

}  // namespace boxunion

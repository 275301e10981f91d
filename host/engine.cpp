#include "host/engine.hpp"

#include <tbb/task_arena.h>

#include "host/cells_method.hpp"
#include "host/slices_method.hpp"
#include "host/stopwatch.hpp"

namespace boxunion {
namespace {

/// Runs f within the threads that the options allow.
template <class F>
void with_threads(const Options& options, F&& f) {
  if (options.threads <= 0) return f();
  tbb::task_arena arena(options.threads);
  arena.execute(f);
}

/// The ordinals of the boxes; the method cells reads those of three lattices by itself.
Ordinals find_ordinals(const BoxSet& boxes, const Options& options) {
  if (options.method == Method::cells)
    if (std::optional<Axes> axes = find_lattices(boxes)) return {std::move(*axes), {}};
  return make_ordinals(boxes);
}

/// Runs the method that the options ask for; see unite_by_cells about `vertices` and `mass`.
void unite(const BoxSet& boxes, Ordinals ordinals, const Options& options, VertexSink* vertices,
           MassSink* mass, Report& report) {
  if (options.method == Method::cells)
    unite_by_cells(boxes, std::move(ordinals), options, vertices, mass, report);
  else
    unite_by_slices(std::move(ordinals.boxes), options, mass ? *mass : *vertices, report);
}

/// What every run begins and ends with: f(ordinals, report) does the rest, on the threads asked for.
template <class F>
void run(const BoxSet& boxes, const Options& options, Report* report, F&& f) {
  Report own;
  Report& r = report ? *report : own;
  r = {};
  with_threads(options, [&] {
    Stopwatch watch(r);
    validate(boxes);
    Ordinals ordinals = find_ordinals(boxes, options);
    watch.lap("ordinals");
    f(std::move(ordinals), r);
    watch.total();
  });
}

}  // namespace

MassProperties measure(const BoxSet& boxes, const Options& options, Report* report) {
  MassProperties result;
  run(boxes, options, report, [&](Ordinals ordinals, Report& r) {
    MassSink sink(ordinals.axes);
    if (options.statistics) {
      MaskCounter counter(sink);
      unite(boxes, std::move(ordinals), options, &counter, nullptr, r);
      Stopwatch sums(r);
      r.statistics = {sum_boxes(boxes), vertex_kinds(counter.counts())};
      sums.lap("statistics");
    } else {
      unite(boxes, std::move(ordinals), options, nullptr, &sink, r);
    }
    result = sink.result();
  });
  return result;
}

Solid unite(const BoxSet& boxes, const Options& options, Report* report) {
  Solid solid;
  run(boxes, options, report, [&](Ordinals ordinals, Report& r) {
    Axes axes = ordinals.axes;
    SolidSink sink;
    unite(boxes, std::move(ordinals), options, &sink, nullptr, r);
    Stopwatch sort(r);
    solid = sink.take(std::move(axes));
    sort.lap("sort");
  });
  return solid;
}

}  // namespace boxunion

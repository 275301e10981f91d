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

}  // namespace

MassProperties measure(const BoxSet& boxes, const Options& options, Report* report) {
  Report own;
  Report& r = report ? *report : own;
  r = {};
  MassProperties result;
  with_threads(options, [&] {
    Stopwatch watch(r);
    validate(boxes);
    const Axes axes = make_axes(boxes);
    watch.lap("axes");
    MassSink sink(axes);
    if (options.method == Method::cells)
      unite_by_cells(boxes, axes, options, nullptr, &sink, r);
    else
      unite_by_slices(ordinal_boxes(boxes, axes), options, sink, r);
    result = sink.result();
    watch.total("total");
  });
  return result;
}

Solid unite(const BoxSet& boxes, const Options& options, Report* report) {
  Report own;
  Report& r = report ? *report : own;
  r = {};
  Solid solid;
  with_threads(options, [&] {
    Stopwatch watch(r);
    validate(boxes);
    Axes axes = make_axes(boxes);
    watch.lap("axes");
    SolidSink sink;
    if (options.method == Method::cells)
      unite_by_cells(boxes, axes, options, &sink, nullptr, r);
    else
      unite_by_slices(ordinal_boxes(boxes, axes), options, sink, r);
    Stopwatch sort(r);
    solid = sink.take(std::move(axes));
    sort.lap("sort");
    watch.total("total");
  });
  return solid;
}

}  // namespace boxunion

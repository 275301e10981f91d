#include "host/engine.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "host/cells_method.hpp"
#include "host/slices_method.hpp"
#include "host/stopwatch.hpp"
#include "host/threads.hpp"

namespace boxunion {
namespace {

/// The ordinals of the boxes; the method cells reads those of three lattices by itself.
Ordinals find_ordinals(std::span<const BoxSet> sets, const Options& options) {
  if (options.method == Method::cells)
    if (std::optional<Axes> axes = find_lattices(sets)) return {std::move(*axes), {}, {}};
  return make_ordinals(sets);
}

/// An expression over sets of boxes, and how it is to be found.
struct Job {
  const Expression& expression;
  std::span<const BoxSet> sets;
  const Options& options;
};

/// Throws for what cannot be done.
void check(const Job& job) {
  const std::size_t operands = job.expression.names().size();
  if (job.sets.size() != operands)
    throw Error(ErrorKind::usage, fmt::format("{} sets of boxes, expected {}", job.sets.size(), operands));
  if (job.options.statistics && operands != 1)
    throw Error(ErrorKind::usage, "statistics are of one set of boxes");
  if (job.options.method == Method::slices && !job.expression.is_union())
    throw Error(ErrorKind::usage, "the method slices finds unions only");
  for (const BoxSet& set : job.sets) validate(set);
}

/// Runs the method that the options ask for; see combine_by_cells about `vertices` and `mass`.
void combine(const Job& job, Ordinals ordinals, VertexSink* vertices, MassSink* mass, Report& report) {
  if (job.options.method == Method::cells)
    combine_by_cells(job.expression, job.sets, std::move(ordinals), job.options, vertices, mass, report);
  else
    unite_by_slices(std::move(ordinals.boxes), job.options, mass ? *mass : *vertices, report);
}

/// What every run begins and ends with: f(ordinals, report) does the rest, on the threads asked for.
template <class F>
void run(const Job& job, Report* report, F&& f) {
  Report own;
  Report& r = report ? *report : own;
  r = {};
  with_threads(job.options.threads, job.options.interrupted, [&] {
    Stopwatch watch(r);
    check(job);
    Ordinals ordinals = find_ordinals(job.sets, job.options);
    watch.lap("ordinals");
    f(std::move(ordinals), r);
    watch.total();
  });
}

}  // namespace

MassProperties measure(const Expression& expression, std::span<const BoxSet> sets, const Options& options,
                       Report* report) {
  const Job job{expression, sets, options};
  MassProperties result;
  run(job, report, [&](Ordinals ordinals, Report& r) {
    MassSink sink(ordinals.axes);
    if (options.statistics) {
      MaskCounter counter(sink);
      combine(job, std::move(ordinals), &counter, nullptr, r);
      Stopwatch sums(r);
      r.statistics = {sum_boxes(sets[0]), vertex_kinds(counter.counts())};
      sums.lap("statistics");
    } else {
      combine(job, std::move(ordinals), nullptr, &sink, r);
    }
    result = sink.result();
  });
  return result;
}

Solid combine(const Expression& expression, std::span<const BoxSet> sets, const Options& options,
              Report* report) {
  const Job job{expression, sets, options};
  Solid solid;
  run(job, report, [&](Ordinals ordinals, Report& r) {
    SolidSink sink(ordinals.axes);
    combine(job, std::move(ordinals), &sink, nullptr, r);
    Stopwatch sort(r);
    solid = sink.take();
    sort.lap("sort");
  });
  return solid;
}

MassProperties measure(const BoxSet& boxes, const Options& options, Report* report) {
  return measure(Expression::one_operand(), {&boxes, 1}, options, report);
}

Solid unite(const BoxSet& boxes, const Options& options, Report* report) {
  return combine(Expression::one_operand(), {&boxes, 1}, options, report);
}

}  // namespace boxunion

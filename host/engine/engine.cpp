#include <fmt/format.h>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/anchored/anchored.hpp"
#include "core/solid/solid_sink.hpp"
#include "core/solid/statistics.hpp"
#include "host/engine/cells_method.hpp"
#include "host/engine/slices_method.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/engine/threads.hpp"

namespace boxunion {
namespace {

/// An expression over sets of boxes, and the options of its computation.
struct Job {
  const Expression& expression;
  std::span<const BoxSet> sets;
  const Options& options;
};

/// Throws Error(usage) for impossible combinations, Error(input) for invalid boxes.
void check(const Job& job) {
  const std::size_t operands = job.expression.names().size();
  if (job.sets.size() != operands)
    throw Error(ErrorKind::usage, fmt::format("{} sets of boxes, expected {}", job.sets.size(), operands));
  if (job.options.statistics && operands != 1)
    throw Error(ErrorKind::usage, "statistics need exactly one set of boxes");
  if (job.options.method == Method::slices && !job.expression.is_union())
    throw Error(ErrorKind::usage, "the method slices finds unions only");
  for (const BoxSet& set : job.sets) validate(set);
}

/// The corner that all boxes share, if they are to be swept.
std::optional<CommonCorner> find_corner(const Job& job) {
  if (!may_sweep_corners(job.options) || job.sets.size() != 1 || !job.expression.is_union())
    return std::nullopt;
  return find_common_corner(job.sets[0]);
}

/// One run on the requested number of threads. The constructor calls f(*this, report).
class Run {
 public:
  template <class F>
  Run(const Job& job, Report* report, F&& f) : job_(job), report_(report ? *report : own_report_) {
    report_ = {};
    with_threads(job.options, [&] {
      Stopwatch watch(report_);
      check(job);
      corner_ = find_corner(job);
      f(*this, report_);
      watch.total();
    });
  }

  /// The sums of boxes with a common corner, if they can be found without vertices.
  std::optional<MassTotals> sum_anchored() {
    if (!corner_) return std::nullopt;
    Stopwatch watch(report_);
    std::optional<MassTotals> totals = boxunion::sum_anchored(job_.sets[0], *corner_);
    if (totals) report_sweep(report_);
    watch.lap("staircase");
    return totals;
  }

  /// The ordinals of the boxes. The method cells reads boxes on three lattices by itself, so these are left
  /// out.
  Ordinals find_ordinals() {
    Stopwatch watch(report_);
    std::optional<Axes> lattices;
    if (job_.options.method != Method::slices && !corner_) lattices = find_lattices(job_.sets);
    Ordinals ordinals = lattices ? Ordinals{std::move(*lattices), {}, {}} : make_ordinals(job_.sets);
    watch.lap("ordinals");
    return ordinals;
  }

  /// Runs the method that the options ask for. See CellsJob for `vertices` and `mass`.
  void combine(Ordinals ordinals, VertexSink* vertices, MassSink* mass) {
    VertexSink& sink = mass ? *mass : *vertices;
    if (corner_) {
      report_sweep(report_);
      Stopwatch watch(report_);
      unite_anchored(ordinals.boxes, *corner_, sink);
      watch.lap("staircase");
    } else if (job_.options.method == Method::slices) {
      unite_by_slices(std::move(ordinals.boxes), job_.options, sink, report_);
    } else {
      combine_by_cells({job_.expression, job_.sets, std::move(ordinals), job_.options, vertices, mass},
                       report_);
    }
  }

 private:
  const Job& job_;
  Report own_report_;
  Report& report_;
  std::optional<CommonCorner> corner_;
};

}  // namespace

MassProperties measure(const Expression& expression, std::span<const BoxSet> sets, const Options& options,
                       Report* report) {
  const Job job{expression, sets, options};
  MassProperties result;
  const Run done(job, report, [&](Run& run, Report& r) {
    if (const std::optional<MassTotals> totals = run.sum_anchored()) {
      result = totals->result();
      return;
    }
    Ordinals ordinals = run.find_ordinals();
    MassSink sink(ordinals.axes);
    if (options.statistics) {
      MaskCounter counter(sink);
      run.combine(std::move(ordinals), &counter, nullptr);
      Stopwatch sums(r);
      r.statistics = {sum_boxes(sets[0]), vertex_kinds(counter.counts())};
      sums.lap("statistics");
    } else {
      run.combine(std::move(ordinals), nullptr, &sink);
    }
    result = sink.result();
  });
  return result;
}

Solid combine(const Expression& expression, std::span<const BoxSet> sets, const Options& options,
              Report* report) {
  const Job job{expression, sets, options};
  Solid solid;
  const Run done(job, report, [&](Run& run, Report& r) {
    Ordinals ordinals = run.find_ordinals();
    SolidSink sink(ordinals.axes);
    run.combine(std::move(ordinals), &sink, nullptr);
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

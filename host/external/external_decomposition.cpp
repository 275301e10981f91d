#include "host/external/external_decomposition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/models/box_sweep.hpp"
#include "core/models/face_join.hpp"
#include "host/engine/stopwatch.hpp"
#include "host/external/sorted_runs.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBlock = 1 << 14;  // records written at once

/// The face of a box at one end of an axis, in the form that FaceJoin takes.
template <class C>
struct FaceRecord {
  C plane, p_lo, is_above, q_lo, p_hi, q_hi;  // all of one width, so that there is no padding

  friend bool operator<(const FaceRecord& a, const FaceRecord& b) {
    return std::tie(a.plane, a.p_lo, a.is_above, a.q_lo) < std::tie(b.plane, b.p_lo, b.is_above, b.q_lo);
  }
};

/// A box on disk, its corners in the order of the axes.
template <class C>
struct BoxRecord {
  OrderedPoint<3, C> lo, hi;

  friend bool operator<(const BoxRecord& a, const BoxRecord& b) { return a.lo < b.lo; }
};

template <class C>
class Decomposer {
 public:
  Decomposer(ExternalUnion& solid, std::optional<BoxModel> model, Report& report)
      : solid_(solid), model_(model), report_(report) {}

  ExternalModel run(const std::optional<AxisOrder>& wanted, std::optional<Connectivity> connectivity,
                    std::optional<OutputFile> file) {
    // passes: sorting five more orders and counting six; a sweep and the faces of two axes; counting boxes
    // and a sweep, or a sweep and merging
    solid_.expect_passes((model_ && !wanted ? 11 : 0) + (model_ && connectivity ? 3 : 0) + (model_ ? 2 : 1));
    ExternalModel result;
    result.order = wanted.value_or(kAxisOrders[0]);
    std::unique_ptr<Corners> points = find_points(result.order);
    Stopwatch watch(report_);
    std::optional<std::uint64_t> count;
    if (!model_)
      count = points->count();
    else if (!wanted)
      std::tie(result.order, count) = choose_order(points);
    watch.lap("evm");
    if (model_ && connectivity) {
      result.pairs = count_neighbors(*points, result.order, *connectivity);
      watch.lap("neighbors");
    }
    if (!count && (!file || model_ == BoxModel::oudb)) count = count_boxes(*points, result.order);
    if (!file) {
      result.elements = *count;
    } else {
      result.elements = write(*points, result.order, count, *file);
      file->commit();
    }
    watch.lap(model_ ? "boxes" : "merge and write");
    watch.total();
    return result;
  }

 private:
  using Corner = OrderedPoint<3, C>;
  using Corners = SortedRuns<Corner>;
  using AddBox = std::function<void(const Corner& lo, const Corner& hi)>;
  using Record = BoxRecord<C>;
  using Face = FaceRecord<C>;
  using Faces = SortedRuns<Face>;

  /// Finds the extreme vertices, in order.
  std::unique_ptr<Corners> find_points(const AxisOrder& order) {
    const std::uint64_t half = solid_.bytes() / 2;
    auto points = std::make_unique<Corners>(half, thread_count(), solid_.scratch_file());
    solid_.unite<C>(half, [&](std::span<const ExternalVertex<C>> vertices) {
      std::vector<Corner> extreme;
      for (const ExternalVertex<C>& v : vertices)
        if (kOctants[v.mask].extreme) extreme.push_back({v.at[order[0]], v.at[order[1]], v.at[order[2]]});
      points->add(extreme);
    });
    return points;
  }

  /// Passes all records to f(span) in order.
  template <class T, class F>
  void each_block(SortedRuns<T>& runs, std::uint64_t bytes, F&& f) {
    solid_.begin_pass(runs.count());
    runs.merge(bytes, [&](std::span<const T> block) {
      f(block);
      solid_.advance(block.size());
    });
  }

  std::unique_ptr<Corners> reorder(Corners& points, const AxisOrder& from, const AxisOrder& to) {
    std::array<std::size_t, 3> place{};  // of each new axis in the old order
    for (std::size_t i = 0; i < 3; ++i)
      place[i] = std::size_t(std::find(from.begin(), from.end(), to[i]) - from.begin());
    auto result = std::make_unique<Corners>(solid_.bytes() / 2, 1, solid_.scratch_file());
    std::vector<Corner> moved;
    each_block(points, solid_.bytes() / 4, [&](std::span<const Corner> block) {
      moved.clear();
      for (const Corner& p : block) moved.push_back({p[place[0]], p[place[1]], p[place[2]]});
      result->add(moved);
    });
    return result;
  }

  /// Sorts `points`, which are in the first order, into the order that gives the fewest boxes. Returns that
  /// order and the number of boxes. One order may give far more boxes than another, so no count goes much
  /// beyond the best one.
  std::pair<AxisOrder, std::uint64_t> choose_order(std::unique_ptr<Corners>& points) {
    std::pair<AxisOrder, std::uint64_t> best;
    std::unique_ptr<Corners> best_points;
    for (std::uint64_t limit = 8 * points->count();; limit *= 8) {
      best.second = limit + 1;
      for (const AxisOrder& order : kAxisOrders) {
        std::unique_ptr<Corners> candidate;
        if (order != kAxisOrders[0]) candidate = reorder(*points, kAxisOrders[0], order);
        const std::uint64_t count = count_boxes(candidate ? *candidate : *points, order, best.second - 1);
        if (count >= best.second) continue;
        best = {order, count};
        best_points = std::move(candidate);
      }
      if (best.second > limit) continue;
      if (best_points) points = std::move(best_points);
      return best;
    }
  }

  /// Calls `add` for every box, in order for the OUDB and as they end for the CUDB.
  void sweep(Corners& points, const AxisOrder& order, const AddBox& add) {
    if (model_ == BoxModel::oudb)
      sweep(OudbSweep<C>(), points, order, add);
    else
      sweep(CudbSweep<C>(), points, order, add);
  }
  template <class Sweep>
  void sweep(Sweep sweep, Corners& points, const AxisOrder& order, const AddBox& add) {
    constexpr std::uint64_t kVertexBytes = sizeof(OrderedPoint<2, C>) + Sweep::kVertexBytes;
    const std::uint64_t half = solid_.bytes() / 2;
    ExtremeVertices<2, C> plane;
    std::uint64_t count = 0, most = half / kVertexBytes;  // vertices of the plane; how many fit
    C a = 0;
    const auto pass = [&] {
      if (count > most) throw_too_large(count * kVertexBytes + sweep.bytes(), order);
      sweep.pass(plane, a, add);
      plane.clear();
      count = 0;
      most = half <= sweep.bytes() ? 0 : (half - sweep.bytes()) / kVertexBytes;
    };
    each_block(points, solid_.bytes() / 8, [&](std::span<const Corner> block) {
      for (const Corner& p : block) {
        if (count > 0 && p[0] != a) pass();
        a = p[0];
        ++count;
        if (count <= most) plane.push_back({p[1], p[2]});
      }
    });
    if (count > 0) pass();
    sweep.finish(add);
  }

  [[noreturn]] void throw_too_large(std::uint64_t bytes, const AxisOrder& order) const {
    throw Error(ErrorKind::resources,
                fmt::format("a section of the sweep along {} does not fit the budget: expected --memory of "
                            "at least {} MiB",
                            "xyz"[order[0]], (solid_.budget_for(2 * bytes) >> 20) + 1));
  }

  /// The number of boxes, or most + 1 if there are more than `most`.
  std::uint64_t count_boxes(Corners& points, const AxisOrder& order,
                            std::uint64_t most = std::uint64_t{1} << 62) {
    struct TooMany {};
    std::uint64_t count = 0;
    try {
      sweep(points, order, [&](const Corner&, const Corner&) {
        if (++count > most) throw TooMany();
      });
    } catch (const TooMany&) {
    }
    return count;
  }

  /// The number of pairs of boxes that are neighbors: see Adjacency.
  std::uint64_t count_neighbors(Corners& points, const AxisOrder& order, Connectivity connectivity) {
    const auto make_runs = [&] {
      return std::make_unique<Faces>(solid_.bytes() / 8, 1, solid_.scratch_file());
    };
    const std::array<std::unique_ptr<Faces>, 2> faces = {make_runs(), make_runs()};
    sweep(points, order, [&](const Corner& lo, const Corner& hi) {
      for (const unsigned axis : {0u, 1u}) {
        const unsigned p = 1 - axis;
        faces[axis]->add(Face{lo[axis], lo[p], 1, lo[2], hi[p], hi[2]});
        faces[axis]->add(Face{hi[axis], lo[p], 0, lo[2], hi[p], hi[2]});
      }
    });
    for (const auto& runs : faces) runs->finish();
    const bool touch = connectivity == Connectivity::points;
    return count_pairs(*faces[0], {touch, touch}) + count_pairs(*faces[1], {false, touch});
  }

  /// Joins faces plane by plane. Only the faces on a line are in memory; they are no more than a section of
  /// the sweep.
  std::uint64_t count_pairs(Faces& faces, FaceJoin<Face> join) {
    std::uint64_t pairs = 0;
    std::vector<Face> below, above;  // faces that begin at a line
    C plane = 0, p = 0;
    const auto advance = [&] {
      join.advance(below, above, [&](const Face&, const Face&) { ++pairs; });
      below.clear();
      above.clear();
    };
    each_block(faces, solid_.bytes() / 4, [&](std::span<const Face> block) {
      for (const Face& f : block) {
        if (f.plane != plane || f.p_lo != p) advance();
        if (f.plane != plane) join.clear();
        plane = f.plane;
        p = f.p_lo;
        (f.is_above ? above : below).push_back(f);
      }
    });
    advance();
    return pairs;
  }

  /// Writes the elements and returns their number. `count` is known beforehand, except for the CUDB.
  std::uint64_t write(Corners& points, const AxisOrder& order, std::optional<std::uint64_t> count,
                      OutputFile& file) {
    if (!model_) {
      PointWriter writer(file, *count);
      std::vector<Point> block;
      each_block(points, solid_.bytes() / 2, [&](std::span<const Corner> some) {
        block.resize(some.size());
        for (std::size_t i = 0; i < some.size(); ++i)
          for (std::size_t k = 0; k < 3; ++k) block[i][order[k]] = coordinate(order[k], some[i][k]);
        writer.write(block);
      });
      return *count;
    }
    // boxes are integers exactly when those from memory are, even if there are none
    const bool integers =
        (std::is_same_v<C, std::uint32_t> || points.count() == 0) && hold_int32(solid_.axes());
    return integers ? write_boxes<std::int32_t>(points, order, count, file)
                    : write_boxes<double>(points, order, count, file);
  }

  template <class T>
  std::uint64_t write_boxes(Corners& points, const AxisOrder& order, std::optional<std::uint64_t> count,
                            OutputFile& file) {
    std::vector<BoxOf<T>> block;
    const auto put = [&](BoxWriter<T>& writer, const Corner& lo, const Corner& hi) {
      BoxOf<T>& box = block.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        box[order[k]] = T(coordinate(order[k], lo[k]));
        box[order[k] + 3u] = T(coordinate(order[k], hi[k]));
      }
      if (block.size() < kBlock) return;
      writer.write(block);
      block.clear();
    };
    if (model_ == BoxModel::oudb) {
      BoxWriter<T> writer(file, *count);
      sweep(points, order, [&](const Corner& lo, const Corner& hi) { put(writer, lo, hi); });
      writer.write(block);
      return *count;
    }
    SortedRuns<Record> boxes(solid_.bytes() / 4, 1, solid_.scratch_file());
    sweep(points, order, [&](const Corner& lo, const Corner& hi) { boxes.add(Record{lo, hi}); });
    BoxWriter<T> writer(file, boxes.count());
    each_block(boxes, solid_.bytes() / 4, [&](std::span<const Record> some) {
      for (const Record& box : some) put(writer, box.lo, box.hi);
    });
    writer.write(block);
    return boxes.count();
  }

  double coordinate(std::size_t axis, C c) const { return external_coordinate(solid_.axes()[axis], c); }

  ExternalUnion& solid_;
  std::optional<BoxModel> model_;
  Report& report_;
};

}  // namespace

ExternalModel decompose(ExternalUnion& solid, std::optional<BoxModel> model,
                        const std::optional<AxisOrder>& order, std::optional<Connectivity> connectivity,
                        std::optional<OutputFile> file, Report& report) {
  if (order) validate(*order);
  if (connectivity) validate(*connectivity);
  ExternalModel result;
  solid.with_coordinates([&]<class C>(C) {
    result = Decomposer<C>(solid, model, report).run(order, connectivity, std::move(file));
  });
  return result;
}

}  // namespace boxunion

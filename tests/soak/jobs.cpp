#include "tests/soak/jobs.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/error.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "core/base/parallel.hpp"
#include "core/models/sections.hpp"
#include "host/device/device.hpp"
#include "host/engine/threads.hpp"
#include "host/external/external_boundary.hpp"
#include "host/external/external_decomposition.hpp"
#include "tests/soak/random.hpp"
#include "tests/support/boxes_in_memory.hpp"
#include "tests/support/families.hpp"
#include "tests/support/reference.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion::soak {
namespace {

// ---- boxes ----

IntegerBox at(Random& random, int range, const std::array<int, 3>& edge) {
  IntegerBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    box[a] = random.below(range);
    box[a + 3] = box[a] + edge[a];
  }
  return box;
}

struct Kind {
  const char* name;
  std::function<IntegerBox(Random&, int range, int edge)> box;  // about `edge` long, in 0 .. range
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {"cubes",
       [](Random& r, int range, int edge) {
         return at(r, range, {edge, edge, edge});
       }},
      {"mixed sizes",
       [](Random& r, int range, int edge) {
         const auto size = [&] { return int(r.between(1, 4.0 * edge)); };
         return at(r, range, {size(), size(), size()});
       }},
      {"rods",
       [](Random& r, int range, int edge) {
         std::array<int, 3> size{1 + edge / 8, 1 + edge / 8, 1 + edge / 8};
         size[std::size_t(r.below(3))] = range;
         return at(r, range, size);
       }},
      {"one plane",
       [](Random& r, int range, int edge) {
         IntegerBox box = at(r, range, {edge, edge, 1});
         box[2] = 5, box[5] = 6;
         return box;
       }},
      {"clusters",
       [](Random& r, int range, int edge) {
         const int center = range / 8 * r.below(8);
         IntegerBox box = at(r, 2 * edge, {edge, edge, edge});
         for (int& c : box) c += center;
         return box;
       }},
      {"nested",
       [](Random& r, int range, int) {
         const int size = 1 + r.below(range);
         return IntegerBox{0, 0, 0, size, size, size};
       }},
      {"with a common corner",
       [](Random& r, int range, int) {
         return IntegerBox{r.below(range), r.below(range), r.below(range), range, range, range};
       }},
      {"touching",
       [](Random& r, int range, int edge) {
         IntegerBox box = at(r, range / edge + 1, {1, 1, 1});
         for (int& c : box) c *= edge;
         return box;
       }},
  };
  return all;
}

BoxSet make_family(Random& random, Job& job) {
  const Family& family = families()[std::size_t(random.below(int(families().size())))];
  const RowOrder order = kRowOrders[random.below(3)];
  BoxSet boxes =
      reorder(family.make(std::size_t(random.between(1, random.one_in(20) ? 20'000 : 600))), order);
  job.count = boxes.size();
  job.boxes_name = fmt::format("{} {} {}", job.count, family.name, name(order));
  return boxes;
}

BoxSet make_boxes(Random& random, Job& job) {
  if (random.one_in(3)) return make_family(random, job);
  const Kind& kind = random.one_of(kinds());
  job.count = std::size_t(random.between(1, random.one_in(20) ? 20'000 : 600));
  const int range = random.one_in(3) ? 12 : int(random.between(20, 100'000));
  const double volumes = random.between(0.01, 4);  // sum of volumes, in universes
  const int edge = std::max(1, int(range * std::cbrt(volumes / double(job.count))));
  std::vector<IntegerBox> integers(job.count);
  for (IntegerBox& box : integers) box = kind.box(random, range, edge);
  job.boxes_name = fmt::format("{} {} of edge {} in {}", job.count, kind.name, edge, range);
  const int form = random.below(4);
  if (form == 0) return integers;
  // doubles on a lattice, on no lattice, or far from the origin
  const double scale = form == 1 ? 0.125 : form == 2 ? 0.1 : 1;
  const double offset = form == 3 ? 0x1p40 : -3;
  job.boxes_name += fmt::format(", times {} plus {}", scale, offset);
  std::vector<Box> boxes(integers.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t c = 0; c < 6; ++c) boxes[i][c] = scale * integers[i][c] + offset;
  return boxes;
}

// ---- ways ----

/// A budget that is enough for every job.
constexpr std::uint64_t kAmple = std::uint64_t{1} << 30;

Slabs make_slabs(Random& random, const Job& job) {
  Slabs slabs;
  slabs.boxes = std::uint64_t(random.between(2, 2.0 * double(job.count)));
  const bool lean =
      job.options.device == "native" && job.options.method != Method::slices && random.one_in(2);
  slabs.bytes = lean ? std::uint64_t(random.between(101 << 20, double(kAmple))) : 2 * kAmple;
  slabs.file =
      random.one_of<std::string>({"", "", "", "vertices.csv", "vertices.npy", "evm.npy", "oudb.npy",
                                  "cudb.npy", "cudb.csv", "a.ply", "a.obj", "a.off", "a.stl", "a.3mf"});
  if (job.count > 2000 && slabs.file == "oudb.npy") slabs.file = "cudb.npy";
  if (slabs.file.starts_with("oudb")) slabs.model = BoxModel::oudb;
  if (slabs.file.starts_with("cudb")) slabs.model = BoxModel::cudb;
  if (!random.one_in(3)) slabs.order = kAxisOrders[std::size_t(random.below(6))];
  if (slabs.model && random.one_in(2))
    slabs.connectivity = random.one_in(2) ? Connectivity::faces : Connectivity::points;
  slabs.contacts = random.one_in(2) ? NonManifold::split : NonManifold::keep;
  return slabs;
}

}  // namespace

Job make_job(std::uint64_t seed, const std::vector<std::string>& devices) {
  Random random(seed);
  Job job;
  job.boxes = make_boxes(random, job);
  Options& options = job.options;
  const Method fast = random.one_in(2) ? Method::automatic : Method::cells;
  options.method = job.count <= 2000 && random.one_in(3) ? Method::slices : fast;
  options.kernel = job.count <= 300 && random.one_in(4) ? CellKernel::faces : CellKernel::occupancy;
  options.device = random.one_of(devices);
  options.threads = random.below(4);
  options.tuning.shape = random.one_in(2) ? Shape::group : Shape::item;
  options.tuning.workgroup = random.one_of<std::uint32_t>({1, 8, 16, 32, 64});
  if (random.one_in(2)) options.tuning.tile_coordinates = std::uint32_t(2 + random.below(30));
  if (random.one_in(3)) options.tuning.cell = std::uint32_t(random.between(1, 1 << 19));
  if (job.count > 600) options.tuning.cell = 0;  // a cell of few ordinals would hold almost no box
  if (random.one_in(3)) options.tuning.cell_boxes = std::uint32_t(random.between(1, 64));
  if (options.device != "native" && random.one_in(3))
    job.failure = fmt::format(
        "{}:{}",
        random.one_of<std::string>({"load", "allocate", "upload", "clear", "dispatch", "download", "wait"}),
        1 + random.below(8));
  job.at_once = job.failure.empty() && random.one_in(4);
  if (random.one_in(4)) job.disturbance = random.between(0.01, 1);
  if (random.one_in(2)) job.slabs = make_slabs(random, job);
  return job;
}

std::string name(const Job& job) {
  const Options& o = job.options;
  const std::string slabs =
      job.slabs ? fmt::format("; slabs of {}, {} bytes, {}", job.slabs->boxes, job.slabs->bytes,
                              job.slabs->file.empty() ? "mass" : job.slabs->file)
                : "";
  const std::string disturbance =
      job.disturbance ? fmt::format(", disturbed at {:.3f}", *job.disturbance) : "";
  return fmt::format(
      "{}; {} {} on {}, {} threads, {} of {}, tile {}, cell {}, cell boxes {}{}{}{}{}", job.boxes_name,
      o.method == Method::automatic ? "auto"
      : o.method == Method::slices  ? "slices"
                                    : "cells",
      o.kernel == CellKernel::faces ? "faces" : "occupancy", o.device, o.threads,
      *o.tuning.shape == Shape::group ? "groups" : "items", o.tuning.workgroup, o.tuning.tile_coordinates,
      o.tuning.cell, o.tuning.cell_boxes, job.failure.empty() ? "" : ", fails at " + job.failure,
      job.at_once ? ", two at once" : "", disturbance, slabs);
}

namespace {

// ---- laws ----

bool is_closed(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      ++sides[{t[i], t[(i + 1) % 3]}];
      --sides[{t[(i + 1) % 3], t[i]}];
    }
  return std::ranges::all_of(sides, [](const auto& side) { return side.second == 0; });
}

/// Writes the file of a job, computed in memory.
void write_from_memory(const Solid& solid, const Slabs& slabs, OutputFile out) {
  if (slabs.file.starts_with("vertices")) return write_vertices(solid, std::move(out));
  if (slabs.file.starts_with("a.")) {
    const Boundary boundary = find_boundary(solid, slabs.contacts, {});
    write_mesh(boundary.brep, boundary.triangulation, false, std::move(out));
    return;
  }
  Evm evm = make_evm(solid, slabs.order.value_or(kAxisOrders[0]));
  if (!slabs.model) return write_extreme_vertices(evm, std::move(out));
  if (!slabs.order)
    for (const AxisOrder& order : kAxisOrders)
      if (Evm other = make_evm(solid, order);
          count_boxes(other, *slabs.model) < count_boxes(evm, *slabs.model))
        evm = std::move(other);
  write_boxes(to_boxes(decompose(evm, *slabs.model)), std::move(out));
}

/// True if the boxes reach beyond the floats of an .stl.
bool is_beyond_floats(const BoxSet& boxes) {
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (const double c : boxes[i])
      if (std::abs(c) > std::numeric_limits<float>::max()) return true;
  return false;
}

/// Does the job in slabs. Returns a description of the fault, or nothing.
std::string run_in_slabs(const Job& job, const MassProperties& mass, const Solid& solid,
                         std::map<std::string, int>& done) try {
  const Slabs& slabs = *job.slabs;
  const TemporaryFolder folder;
  const BoxesInMemory file(job.boxes);
  Report report;
  ExternalUnion external(file, job.options, {slabs.bytes, folder.file(""), slabs.boxes}, report);
  if (slabs.file.empty()) {
    if (!(external.measure() == mass)) return "mass properties in slabs differ";
    ++done["mass in slabs"];
    return {};
  }
  const auto open = [&](const std::string& name) {
    return open_output(folder.file(name), FileUse::boundary);
  };
  if (slabs.file.starts_with("vertices") || slabs.file.starts_with("a.")) {
    write_boundary(external, slabs.contacts, false, open("slabs_" + slabs.file), report);
  } else {
    const ExternalModel made = decompose(external, slabs.model, slabs.order, slabs.connectivity,
                                         open("slabs_" + slabs.file), report);
    if (slabs.connectivity) {
      const Decomposition boxes = decompose(make_evm(solid, made.order), *slabs.model);
      if (made.pairs != find_neighbors(boxes, *slabs.connectivity).pairs())
        return "the neighbors counted in slabs differ";
      ++done["neighbors in slabs"];
    }
  }
  write_from_memory(solid, slabs, open(slabs.file));
  if (folder.read("slabs_" + slabs.file) != folder.read(slabs.file)) return "the file made in slabs differs";
  ++done["files in slabs"];
  return {};
} catch (const Error& error) {
  if (error.kind() == ErrorKind::input && job.slabs->file == "a.stl" && is_beyond_floats(job.boxes)) {
    ++done["beyond the floats of .stl"];
    return {};
  }
  const bool too_deep =
      std::string_view(error.what()).find("no cut separates them") != std::string_view::npos;
  if (error.kind() != ErrorKind::resources || !(too_deep || job.slabs->bytes < kAmple)) return error.what();
  ++done["did not fit in slabs"];
  return {};
}

/// Everything that is made of a union.
struct Found {
  Solid solid;
  Decomposition boxes;
  Labels labels;
  std::optional<MassProperties> in_slabs;
};

Found find_all(const Job& job, const Options& options) {
  return with_threads(options, [&] {
    Found found;
    found.solid = unite(job.boxes, options);
    find_boundary(found.solid, NonManifold::split, options);
    found.boxes = decompose(make_evm(found.solid, {2, 1, 0}), BoxModel::cudb);
    found.labels = label_components(find_neighbors(found.boxes, Connectivity::points));
    if (job.slabs && job.slabs->bytes >= kAmple) {
      const TemporaryFolder folder;
      const BoxesInMemory file(job.boxes);
      Report report;
      ExternalUnion external(file, options, {job.slabs->bytes, folder.file(""), 0}, report);
      found.in_slabs = external.measure();
    }
    return found;
  });
}

bool same(const Found& a, const Found& b) {
  return a.solid.vertices == b.solid.vertices && a.boxes.boxes == b.boxes.boxes &&
         a.labels.labels == b.labels.labels && a.in_slabs == b.in_slabs;
}

/// Thrown in a piece of parallel work.
struct Injected {};

/// The number of pieces of parallel work so far, and the piece that throws.
std::atomic<std::int64_t> pieces = 0, bad_piece = -1;

void count_piece() {
  if (pieces++ == bad_piece) throw Injected();
}

/// While it exists, all pieces of parallel work are counted.
class CountPieces {
 public:
  explicit CountPieces(std::int64_t bad) {
    pieces = 0;
    bad_piece = bad;
    detail::before_piece = count_piece;
  }
  CountPieces(const CountPieces&) = delete;
  CountPieces& operator=(const CountPieces&) = delete;
  ~CountPieces() { detail::before_piece = nullptr; }
};

/// Makes everything, while something may end the work. It must throw, or give the expected results.
std::string check_ended(const Job& job, const Options& options, const Found& expected,
                        const std::string& word, std::map<std::string, int>& done) {
  try {
    if (!same(find_all(job, options), expected)) return "what was not " + word + " in time differs";
    ++done["not " + word + " in time"];
  } catch (const Injected&) {
    ++done[word];
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::interrupted) return word + ": " + error.what();
    ++done[word];
  }
  return {};
}

/// Makes everything with an exception or an interrupt at some moment, and then once more, which must be as if
/// nothing had happened.
std::string run_disturbed(const Job& job, std::map<std::string, int>& done) {
  using Clock = std::chrono::steady_clock;
  Found expected;
  std::int64_t bad = 0;
  std::chrono::duration<double> moment{};
  {
    const CountPieces count(-1);
    const auto begin = Clock::now();
    expected = find_all(job, job.options);
    moment = (Clock::now() - begin) * *job.disturbance;
    bad = std::int64_t(double(pieces) * *job.disturbance);
  }
  std::string wrong;
  {
    const CountPieces count(bad);
    wrong = check_ended(job, job.options, expected, "ended by an exception", done);
  }
  if (!wrong.empty()) return wrong;

  std::atomic<bool> interrupted = false;
  Options options = job.options;
  options.interrupted = &interrupted;
  {
    const std::jthread timer([&] {
      std::this_thread::sleep_for(moment);
      interrupted = true;
    });
    wrong = check_ended(job, options, expected, "interrupted", done);
  }
  if (!wrong.empty()) return wrong;
  return same(find_all(job, job.options), expected) ? "" : "what follows an interrupt differs";
}

/// Finds mass properties and vertices, by two threads at once if the job says so.
std::pair<MassProperties, Solid> find(const Job& job, Report& report) {
  if (!job.at_once) {
    MassProperties mass = measure(job.boxes, job.options, &report);
    return {mass, unite(job.boxes, job.options)};
  }
  std::future<Solid> solid = std::async(std::launch::async, [&] { return unite(job.boxes, job.options); });
  const MassProperties mass = measure(job.boxes, job.options, &report);
  return {mass, solid.get()};
}

}  // namespace

std::string run(const Job& job, std::map<std::string, int>& done) {
  if (job.failure.empty())
    ::unsetenv("BOXUNION_FAIL_DEVICE");
  else
    ::setenv("BOXUNION_FAIL_DEVICE", job.failure.c_str(), 1);
  Report report;
  const auto [mass, solid] = find(job, report);
  ::unsetenv("BOXUNION_FAIL_DEVICE");
  ++done[report.method + " on " + job.options.device];
  if (job.at_once) ++done["by two threads at once"];
  if (!job.failure.empty() && report.device == "native") ++done["went on natively"];

  const Options plain{.method = job.options.method == Method::slices ? Method::cells : Method::slices,
                      .device = "native",
                      .threads = 1};
  if (job.count <= 2000 || job.options.method == Method::slices) {
    if (unite(job.boxes, plain).vertices != solid.vertices)
      return "vertices are not those of the other method";
  }
  MassSink sink(solid.axes);
  sink.add(solid.vertices);
  if (!(sink.result() == mass)) return "mass properties are not those of the vertices";
  if (job.count <= 12) {
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < job.count; ++i) boxes.push_back(job.boxes[i]);
    if (!(brute_force_mass(boxes) == mass)) return "mass properties are not those of brute force";
    ++done["by brute force"];
  }
  if (job.count <= 2000) {
    if (!is_closed(make_mesh(solid, NonManifold::split))) return "the mesh is not closed";
    if (make_evm(decompose(make_evm(solid, {0, 1, 2}), BoxModel::cudb)).vertices !=
        make_evm(solid, {0, 1, 2}).vertices)
      return "disjoint boxes do not give the extreme vertices back";
  }
  if (job.disturbance)
    if (std::string wrong = run_disturbed(job, done); !wrong.empty()) return wrong;
  if (job.slabs) return run_in_slabs(job, mass, solid, done);
  return {};
}

}  // namespace boxunion::soak

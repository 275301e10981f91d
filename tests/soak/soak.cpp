// Random jobs, each checked against the reference: boxes of many kinds and numbers, by a random way (method,
// kernel, device, launch, sizes of cells, threads), some with a device that fails midway, some in slabs on
// disk.
//
//   boxunion_soak [--jobs N] [--first SEED] [--native]
//
// Job i is all that random numbers from seed SEED + i decide, so one that fails can be run again alone. Few
// boxes are compared with brute force, more with the other method, natively. Exit status 1 where anything
// differs.

#include <fmt/format.h>
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/adjacency.hpp"
#include "core/decomposition.hpp"
#include "core/error.hpp"
#include "core/evm.hpp"
#include "core/triangulation.hpp"
#include "host/boundary.hpp"
#include "host/device.hpp"
#include "host/engine.hpp"
#include "host/external_boundary.hpp"
#include "host/external_decomposition.hpp"
#include "tests/boxes_in_memory.hpp"
#include "tests/reference.hpp"

namespace {

using namespace boxunion;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// 0 .. limit - 1
  int below(int limit) { return int(std::uniform_int_distribution<int>(0, limit - 1)(engine_)); }
  bool one_in(int times) { return below(times) == 0; }
  /// Between low and high; as likely near one size as near ten times that size.
  double between(double low, double high) {
    return low * std::exp(std::uniform_real_distribution<double>(0, std::log(high / low))(engine_));
  }
  template <class T>
  const T& one_of(const std::vector<T>& values) {
    return values[std::size_t(below(int(values.size())))];
  }

 private:
  std::mt19937_64 engine_;
};

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
      {"touching",
       [](Random& r, int range, int edge) {
         IntegerBox box = at(r, range / edge + 1, {1, 1, 1});
         for (int& c : box) c *= edge;
         return box;
       }},
  };
  return all;
}

/// What is made of a union in slabs on disk, compared with the same from memory.
struct Slabs {
  std::uint64_t boxes;  // at most, of a slab
  std::uint64_t bytes;  // of the budget
  std::string file;     // what for: "" for mass properties
  std::optional<BoxModel> model;
  std::optional<AxisOrder> order;
  std::optional<Connectivity> connectivity;  // of neighbours to be counted, of boxes
  NonManifold contacts;
};

struct Job {
  std::string boxes_name;
  BoxSet boxes;
  std::size_t count = 0;
  Options options;
  std::string failure;  // of the device
  std::optional<Slabs> slabs;
};

BoxSet make_boxes(Random& random, Job& job) {
  const Kind& kind = random.one_of(kinds());
  job.count = std::size_t(random.between(1, random.one_in(20) ? 20'000 : 600));
  const int range = random.one_in(3) ? 12 : int(random.between(20, 100'000));
  const double volumes = random.between(0.01, 4);  // their sum, in universes
  const int edge = std::max(1, int(range * std::cbrt(volumes / double(job.count))));
  std::vector<IntegerBox> integers(job.count);
  for (IntegerBox& box : integers) box = kind.box(random, range, edge);
  job.boxes_name = fmt::format("{} {} of edge {} in {}", job.count, kind.name, edge, range);
  const int form = random.below(4);
  if (form == 0) return integers;
  // doubles on a lattice, on none, or far from the origin
  const double scale = form == 1 ? 0.125 : form == 2 ? 0.1 : 1;
  const double offset = form == 3 ? 0x1p40 : -3;
  job.boxes_name += fmt::format(", times {} plus {}", scale, offset);
  std::vector<Box> boxes(integers.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t c = 0; c < 6; ++c) boxes[i][c] = scale * integers[i][c] + offset;
  return boxes;
}

// ---- ways ----

Slabs make_slabs(Random& random, const Job& job) {
  Slabs slabs;
  slabs.boxes = std::uint64_t(random.between(2, 2.0 * double(job.count)));
  const bool lean = job.options.device == "native" && job.options.method == Method::cells && random.one_in(2);
  slabs.bytes = lean ? 101 << 20 : std::uint64_t{2} << 30;
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

Job make_job(std::uint64_t seed, const std::vector<std::string>& devices) {
  Random random(seed);
  Job job;
  job.boxes = make_boxes(random, job);
  Options& options = job.options;
  options.method = random.one_in(3) ? Method::slices : Method::cells;
  if (job.count > 2000) options.method = Method::cells;
  options.kernel = job.count <= 300 && random.one_in(4) ? CellKernel::faces : CellKernel::occupancy;
  options.device = random.one_of(devices);
  options.threads = random.below(4);
  options.tuning.shape = random.one_in(2) ? Shape::group : Shape::item;
  options.tuning.workgroup = random.one_of<std::uint32_t>({1, 8, 16, 32, 64});
  if (random.one_in(2)) options.tuning.tile_coordinates = std::uint32_t(2 + random.below(30));
  if (random.one_in(3)) options.tuning.cell = std::uint32_t(random.between(1, 1 << 19));
  if (job.count > 600) options.tuning.cell = 0;  // a cell of few ordinals would hold hardly a box
  if (random.one_in(3)) options.tuning.cell_boxes = std::uint32_t(random.between(1, 64));
  if (options.device != "native" && random.one_in(3))
    job.failure = fmt::format(
        "{}:{}",
        random.one_of<std::string>({"load", "allocate", "upload", "clear", "dispatch", "download", "wait"}),
        1 + random.below(8));
  if (random.one_in(2)) job.slabs = make_slabs(random, job);
  return job;
}

std::string name(const Job& job) {
  const Options& o = job.options;
  const std::string slabs =
      job.slabs ? fmt::format("; slabs of {}, {} bytes, {}", job.slabs->boxes, job.slabs->bytes,
                              job.slabs->file.empty() ? "mass" : job.slabs->file)
                : "";
  return fmt::format("{}; {} {} on {}, {} threads, {} of {}, tile {}, cell {}, cell boxes {}{}{}",
                     job.boxes_name, o.method == Method::slices ? "slices" : "cells",
                     o.kernel == CellKernel::faces ? "faces" : "occupancy", o.device, o.threads,
                     *o.tuning.shape == Shape::group ? "groups" : "items", o.tuning.workgroup,
                     o.tuning.tile_coordinates, o.tuning.cell, o.tuning.cell_boxes,
                     job.failure.empty() ? "" : ", fails at " + job.failure, slabs);
}

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

/// A folder that is removed with what is in it.
class Folder {
 public:
  Folder() {
    path_ = (std::filesystem::temp_directory_path() / "boxunion-soak-XXXXXX").string();
    if (!::mkdtemp(path_.data())) throw std::runtime_error("cannot create " + path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  std::string read(const std::string& name) const {
    std::ifstream stream(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::string path_;
};

/// Writes the file of a job from memory.
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

/// The same in slabs: what is wrong, or nothing.
std::string run_in_slabs(const Job& job, const MassProperties& mass, const Solid& solid,
                         std::map<std::string, int>& done) try {
  const Slabs& slabs = *job.slabs;
  const Folder folder;
  const BoxesInMemory file(job.boxes);
  Report report;
  ExternalUnion external(file, job.options, {slabs.bytes, folder.file(""), slabs.boxes}, report);
  if (slabs.file.empty()) {
    if (!(external.measure() == mass)) return "mass properties in slabs differ";
    ++done["mass in slabs"];
    return {};
  }
  const auto open = [&](const std::string& name) {
    return open_output(folder.file(name), nullptr, kBoundaryFormats);
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
  const bool too_deep = std::string_view(error.what()).find("no cut helps") != std::string_view::npos;
  if (error.kind() != ErrorKind::resources || !(too_deep || job.slabs->bytes < 1 << 30)) return error.what();
  ++done["did not fit in slabs"];
  return {};
}

/// What is wrong, or nothing.
std::string run(Job& job, std::map<std::string, int>& done) {
  if (job.failure.empty())
    ::unsetenv("BOXUNION_FAIL_DEVICE");
  else
    ::setenv("BOXUNION_FAIL_DEVICE", job.failure.c_str(), 1);
  Report report;
  const MassProperties mass = measure(job.boxes, job.options, &report);
  const Solid solid = unite(job.boxes, job.options);
  ::unsetenv("BOXUNION_FAIL_DEVICE");
  ++done[report.method + " on " + job.options.device];
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
    job.boxes.visit([&]<class T>(const std::vector<BoxOf<T>>& own) {
      for (const BoxOf<T>& box : own) std::ranges::copy(box, boxes.emplace_back().begin());
    });
    if (!(brute_force_mass(boxes) == mass)) return "mass properties are not those of brute force";
    ++done["by brute force"];
  }
  if (job.count <= 2000) {
    if (!is_closed(make_mesh(solid, NonManifold::split))) return "the mesh is not closed";
    if (make_evm(decompose(make_evm(solid, {0, 1, 2}), BoxModel::cudb)).vertices !=
        make_evm(solid, {0, 1, 2}).vertices)
      return "disjoint boxes do not give the extreme vertices back";
  }
  if (job.slabs) return run_in_slabs(job, mass, solid, done);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Random jobs, each checked against the reference.");
  std::uint64_t first = 1, jobs = 100;
  bool native = false;
  app.add_option("--first", first, "Seed of the first job");
  app.add_option("--jobs", jobs, "How many");
  app.add_flag("--native", native, "No OpenCL or Vulkan device");
  CLI11_PARSE(app, argc, argv);

  std::vector<std::string> devices{"native"};
  if (!native) {
    devices.clear();
    for (const DeviceInfo& device : list_devices()) devices.push_back(device.id);
  }
  const auto begin = std::chrono::steady_clock::now();
  std::map<std::string, int> done;
  std::uint64_t wrong = 0;
  for (std::uint64_t seed = first; seed < first + jobs; ++seed) {
    Job job = make_job(seed, devices);
    std::string what;
    try {
      what = run(job, done);
    } catch (const std::exception& error) {
      what = error.what();
    }
    if (!what.empty()) {
      ++wrong;
      fmt::print("seed {}: {}\n  {}\n", seed, what, name(job));
      std::fflush(stdout);
    }
  }
  for (const auto& [what, times] : done) fmt::print("{:8} {}\n", times, what);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{} jobs, seeds {} to {}, in {:.0f} s: {} wrong\n", jobs, first, first + jobs - 1, seconds,
             wrong);
  return wrong == 0 ? 0 : 1;
}

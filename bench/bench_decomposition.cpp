// Tables 1 and 2 of Cruz-Matías and Ayala (CUDB), on generated volumes of the same sizes: bytes of the
// models, and seconds of the conversions and of labelling, for the order XYZ, beside their figures.
// Conversions to boxes include the neighbor lists, as theirs do. Every result is checked before it is timed.
// Prints Markdown. Times are medians.

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/program.hpp"
#include "bench/timing.hpp"
#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "core/voxels/voxel_boxes.hpp"

namespace boxunion {
namespace {

/// A row of their tables: bytes, boxes, seconds.
struct Published {
  std::size_t evm_bytes, oudb_bytes, cudb_bytes, oudb_boxes, cudb_boxes;
  double evm_to_oudb, evm_to_cudb, oudb_to_evm, cudb_to_evm, label_oudb, label_cudb;
};

/// The rival: their labelling (section 3.5, algorithms 3 to 5), in two passes over the boxes with a map of
/// equivalences.
class TwoPassLabels {
 public:
  explicit TwoPassLabels(const Adjacency& adjacency) : labels_(adjacency.backward[0].offsets.size() - 1, 0) {
    std::uint32_t next = 1;
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      std::uint32_t lowest = labels_[i];  // a box may have got its label from a forward neighbor
      const auto for_each_neighbor = [&](auto&& f) {
        for (const NeighborLists& lists : adjacency.backward)
          for (const std::uint32_t other : lists[i]) f(labels_[other]);
      };
      for_each_neighbor([&](std::uint32_t label) {
        if (label != 0) lowest = lowest == 0 ? label : std::min(lowest, label);
      });
      if (lowest == 0) lowest = next++;
      if (labels_[i] != 0) make_equivalence(labels_[i], lowest);
      labels_[i] = lowest;
      for_each_neighbor([&](std::uint32_t& label) {
        if (label != 0) make_equivalence(label, lowest);
        label = lowest;
      });
    }
    for (auto& [from, to] : equivalences_)
      for (auto i = equivalences_.find(to); i != equivalences_.end(); i = equivalences_.find(to))
        to = i->second;
    std::map<std::uint32_t, std::uint32_t> consecutive;
    for (std::uint32_t& label : labels_) {
      if (const auto i = equivalences_.find(label); i != equivalences_.end()) label = i->second;
      label = consecutive.emplace(label, std::uint32_t(consecutive.size() + 1)).first->second;
    }
  }
  const std::vector<std::uint32_t>& labels() const { return labels_; }

 private:
  /// a must be at least b
  void make_equivalence(std::uint32_t a, std::uint32_t b) {
    if (a == b) return;
    const auto [i, is_new] = equivalences_.emplace(a, b);
    if (is_new) return;
    const std::uint32_t old = i->second;
    i->second = std::min(old, b);
    make_equivalence(std::max(old, b), std::min(old, b));
  }
  std::vector<std::uint32_t> labels_;
  std::map<std::uint32_t, std::uint32_t> equivalences_;
};

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error("wrong: " + what);
}

void run(const std::string& name, const Volume& volume, const Published& published, int runs,
         Tables& tables) {
  const Solid solid = unite(voxel_boxes(stream_of(volume)), {.device = "native"});
  const Evm evm = make_evm(solid, {0, 1, 2});
  struct Model {
    Decomposition boxes;
    Adjacency adjacency;
    double from_evm = 0, to_evm = 0, label = 0, label_in_two_passes = 0;
    std::uint32_t components = 0;
    std::size_t bytes() const { return boxes.boxes.size() * sizeof(OrdinalBox) + adjacency.bytes(); }
  };
  const auto measure = [&](BoxModel kind) {
    Model model;
    const auto convert = [&] {
      model.boxes = decompose(evm, kind);
      model.adjacency = find_neighbors(model.boxes, Connectivity::faces);
    };
    convert();
    if (make_evm(model.boxes).vertices != evm.vertices)
      fail(name + ": the boxes do not give the extreme vertices");
    const Labels labels = label_components(model.adjacency);
    if (TwoPassLabels(model.adjacency).labels() != labels.labels) fail(name + ": labels");
    model.components = labels.count;
    model.from_evm = median_seconds(runs, convert);
    model.to_evm = median_seconds(runs, [&] { make_evm(model.boxes); });
    model.label = median_seconds(runs, [&] { label_components(model.adjacency); });
    model.label_in_two_passes = median_seconds(runs, [&] { TwoPassLabels{model.adjacency}; });
    return model;
  };
  const Model oudb = measure(BoxModel::oudb), cudb = measure(BoxModel::cudb);
  if (oudb.components != cudb.components) fail(name + ": components");

  tables.begin("volumes", {"name", "x", "y", "z", "extreme_vertices", "components"});
  tables.add(name, volume.grid.size[0], volume.grid.size[1], volume.grid.size[2], evm.vertices.size(),
             oudb.components);
  tables.begin("sizes", {"volume", "what", "ours", "theirs"});
  tables.add(name, "EVM, bytes", evm.vertices.size() * sizeof(evm.vertices[0]), published.evm_bytes);
  tables.add(name, "OUDB, boxes", oudb.boxes.boxes.size(), published.oudb_boxes);
  tables.add(name, "OUDB, bytes", oudb.bytes(), published.oudb_bytes);
  tables.add(name, "CUDB, boxes", cudb.boxes.boxes.size(), published.cudb_boxes);
  tables.add(name, "CUDB, bytes", cudb.bytes(), published.cudb_bytes);
  const double oudb_scale = double(oudb.boxes.boxes.size()) / double(published.oudb_boxes);
  const double cudb_scale = double(cudb.boxes.boxes.size()) / double(published.cudb_boxes);
  tables.begin("seconds", {"volume", "what", "ours", "theirs", "ratio_by_box"});
  const auto add_times = [&](const char* what, double ours, double theirs, double scale) {
    tables.add(name, what, ours, theirs, theirs * scale / ours);
  };
  add_times("EVM to OUDB", oudb.from_evm, published.evm_to_oudb, oudb_scale);
  add_times("EVM to CUDB", cudb.from_evm, published.evm_to_cudb,
            oudb_scale);  // works through the OUDB's boxes
  add_times("OUDB to EVM", oudb.to_evm, published.oudb_to_evm, oudb_scale);
  add_times("CUDB to EVM", cudb.to_evm, published.cudb_to_evm, cudb_scale);
  add_times("labels on OUDB", oudb.label, published.label_oudb, oudb_scale);
  add_times("labels on CUDB", cudb.label, published.label_cudb, cudb_scale);
  tables.begin("two_passes", {"volume", "what", "ours", "two_passes", "ratio"});
  tables.add(name, "labels on CUDB", cudb.label, cudb.label_in_two_passes,
             cudb.label_in_two_passes / cudb.label);
}

void run_all(const Request& request, Tables& tables) {
  run("Phantom", generate_phantom({500, 500, 500}),
      {57'111, 787'349, 23'156, 24'851, 954, 0.182, 0.163, 0.205, 0.012, 0.088, 0.001}, request.runs, tables);
  run("Aneurysm", generate_porous({213, 215, 240}, {.pores = 0.995, .feature = 7}, 1),
      {666'501, 404'117, 275'347, 12'825, 10'705, 0.351, 0.429, 0.189, 0.139, 0.050, 0.012}, request.runs,
      tables);
  run("Stone", generate_porous({159, 271, 179}, {.pores = 0.885, .feature = 5}, 1),
      {6'739'767, 4'767'472, 2'837'183, 161'751, 124'717, 4.280, 13.233, 2.163, 1.953, 2.004, 0.162},
      request.runs, tables);
}

}  // namespace
}  // namespace boxunion

int main(int argc, char** argv) {
  using namespace boxunion;
  return run_benchmark(
      argc, argv, "Reruns tables 1 and 2 of CUDB on generated volumes of the sizes of theirs.", {}, run_all);
}

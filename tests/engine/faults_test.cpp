// Any piece of any parallel loop may fail. The failure reaches the caller unchanged. Nothing crashes or
// hangs, no file is left, and the next call gives the right result.

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/contour.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/union.hpp"
#include "boxunion/voxels.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/external/external_boundary.hpp"
#include "host/external/external_decomposition.hpp"
#include "host/files/files.hpp"
#include "tests/support/boxes_in_memory.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

std::atomic<std::size_t> pieces;  // begun
std::size_t fail_at = 0;          // the piece that fails, counted from 1; 0: none
bool as_interrupt = false;

/// While it exists, pieces are counted and one of them fails.
class Fault {
 public:
  explicit Fault(std::size_t piece) {
    pieces = 0;
    fail_at = piece;
    detail::before_piece = [] {
      if (++pieces != fail_at) return;
      if (as_interrupt) throw Error(ErrorKind::interrupted, "a test");
      throw std::bad_alloc();
    };
  }
  ~Fault() { detail::before_piece = nullptr; }
};

/// True if work() ends with the injected fault.
bool fails(const std::function<std::string()>& work, const std::string& right) {
  try {
    EXPECT_EQ(work(), right) << "a fault in piece " << fail_at << " passed unseen";
  } catch (const std::bad_alloc&) {
    return !as_interrupt;
  } catch (const Error& error) {
    return error.kind() == (as_interrupt ? ErrorKind::interrupted : ErrorKind::resources);
  }
  return false;
}

/// Makes about `most` pieces of work() fail, one in each run: the first and last ones, and some between.
/// work() returns a summary of its result.
void expect_every_fault_is_seen(const std::function<std::string()>& work, std::size_t most = 60) {
  std::string right;
  {
    const Fault none(0);
    right = work();
  }
  const std::size_t count = pieces;
  ASSERT_GT(count, 0u);
  // loops are cut by which threads are free, so a later run may have fewer pieces
  for (std::size_t i = 0; i < std::min(count, most); ++i) {
    const std::size_t piece = count <= most ? i + 1 : i < most / 4 ? i + 1 : 1 + i * (count - 1) / (most - 1);
    as_interrupt = i % 2 == 1;
    bool failed = false, reached = false;
    {
      const Fault fault(piece);
      try {
        failed = fails(work, right);
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
      }
      reached = pieces >= piece;
    }
    EXPECT_EQ(failed, reached) << "piece " << piece << " of " << count;
  }
  EXPECT_EQ(work(), right);
}

template <class T>
std::string hash_of_bytes(const T& values) {
  return std::to_string(std::hash<std::string_view>()(
      {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])}));
}

BoxSet some_boxes(std::size_t count = 6000) {
  return collect(generate_cubes(count, 900, 32768, 5));
}

/// The same in general position.
BoxSet general_boxes(std::size_t count = 6000) {
  const BoxSet boxes = some_boxes(count);
  std::vector<Box> all;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    Box box = boxes[i];
    for (double& c : box) c = c / 3 + 1e-9 * c * c;
    all.push_back(box);
  }
  return all;
}

const Options kNative{.device = "native"};

std::string summary(const MassProperties& mass) {
  return std::to_string(mass.vertices) + ' ' +
         hash_of_bytes(std::array{mass.volume, mass.area, mass.edge_length});
}

TEST(Faults, InMeasureReachTheCaller) {
  for (const Method method : {Method::cells, Method::slices}) {
    const std::size_t count = method == Method::cells ? 6000 : 1000;  // slices take much longer
    for (const BoxSet& boxes : {some_boxes(count), general_boxes(count)}) {
      Options options = kNative;
      options.method = method;
      expect_every_fault_is_seen([&] { return summary(measure(boxes, options)); }, 30);
    }
  }
}

TEST(Faults, InBoundariesReachTheCaller) {
  const BoxSet boxes = some_boxes();
  const Solid solid = unite(boxes, kNative);
  expect_every_fault_is_seen([&] { return hash_of_bytes(unite(boxes, kNative).vertices); });
  for (const NonManifold contacts : {NonManifold::keep, NonManifold::split}) {
    expect_every_fault_is_seen(
        [&] { return hash_of_bytes(find_boundary(solid, contacts, kNative).triangulation.triangles); });
    expect_every_fault_is_seen([&] { return hash_of_bytes(make_mesh(solid, contacts).triangles); });
  }
}

TEST(Faults, InModelsReachTheCaller) {
  const Solid solid = unite(some_boxes(), kNative);
  for (const AxisOrder& order : {kAxisOrders[0], kAxisOrders[2]})
    for (const BoxModel model : {BoxModel::cudb, BoxModel::oudb})
      expect_every_fault_is_seen(
          [&] { return hash_of_bytes(decompose(make_evm(solid, order), model).boxes); }, 40);
  const Decomposition boxes = decompose(make_evm(solid, kAxisOrders[0]), BoxModel::cudb);
  expect_every_fault_is_seen([&] {
    const Adjacency neighbors = find_neighbors(boxes, Connectivity::points);
    const Labels labels = label_components(neighbors);
    return std::to_string(measure_components(boxes, labels).size());
  });
}

TEST(Faults, InExpressionsReachTheCaller) {
  const std::vector<BoxSet> sets = {some_boxes(), collect(generate_cubes(5000, 1000, 32768, 6))};
  for (const char* text : {"A or B", "A not B", "A xor B"})
    expect_every_fault_is_seen(
        [&] { return hash_of_bytes(combine(Expression::parse(text), sets, kNative).vertices); }, 30);
}

TEST(Faults, InThePlaneReachTheCaller) {
  std::vector<Rectangle> rectangles;
  const BoxSet boxes = some_boxes();
  for (std::size_t i = 0; i < boxes.size(); ++i)
    rectangles.push_back({boxes[i][0], boxes[i][1], boxes[i][3], boxes[i][4]});
  const RectangleSet set(rectangles);
  expect_every_fault_is_seen([&] {
    const Contour contour = find_contour(set);
    return hash_of_bytes(contour.vertices) + std::to_string(find_polygons(contour).loops());
  });
}

TEST(Faults, InVolumesReachTheCaller) {
  const Volume volume = generate_porous({96, 96, 96}, {}, 3);
  std::vector<std::uint32_t> labels(96 * 96 * 96);
  expect_every_fault_is_seen([&] {
    const std::size_t count = label_voxels(volume, Connectivity::points, labels).size();
    return std::to_string(count) + hash_of_bytes(labels);
  });
  expect_every_fault_is_seen([&] { return std::to_string(voxel_boxes(stream_of(volume)).size()); });
}

TEST(Faults, OutOfCoreReachTheCallerAndLeaveNothing) {
  const TemporaryFolder folder, scratch;
  const Budget budget{std::uint64_t{128} << 20, scratch.path(), 1500};
  const auto files = [](const TemporaryFolder& in) {
    return std::distance(std::filesystem::directory_iterator(in.path()), {});
  };
  for (const BoxSet& boxes : {some_boxes(), general_boxes()}) {
    const BoxesInMemory file(boxes);
    const auto with_union = [&](auto&& use) {
      return [&, use] {
        Report report;
        ExternalUnion solid(file, kNative, budget, report);
        return use(solid, report);
      };
    };
    const auto expect = [&](const std::function<std::string()>& work) {
      expect_every_fault_is_seen(
          [&] {
            std::filesystem::remove(folder.file("out.ply"));
            try {
              return work();
            } catch (...) {
              EXPECT_EQ(files(folder), 0) << "a file was left";
              EXPECT_EQ(files(scratch), 0) << "a file was left";
              throw;
            }
          },
          24);
    };
    expect(with_union([](ExternalUnion& solid, Report&) { return summary(solid.measure()); }));
    expect(with_union([&](ExternalUnion& solid, Report& report) {
      return std::to_string(
          write_boundary(solid, NonManifold::split, false, OutputFile(folder.file("out.ply")), report)
              .counts.triangles);
    }));
    expect(with_union([&](ExternalUnion& solid, Report& report) {
      return std::to_string(
          decompose(solid, BoxModel::cudb, kAxisOrders[2], Connectivity::faces, std::nullopt, report).pairs);
    }));
  }
}

}  // namespace
}  // namespace boxunion

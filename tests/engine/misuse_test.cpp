// Arguments that contradict each other or their documentation throw Error(usage). None of them crashes.

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/error.hpp"
#include "boxunion/files.hpp"
#include "boxunion/union.hpp"
#include "boxunion/voxels.hpp"
#include "core/cells/expression.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/external/external_decomposition.hpp"
#include "host/files/files.hpp"
#include "tests/support/boxes_in_memory.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

template <class F>
void expect_usage(F&& f, const std::string& message) {
  try {
    f();
    FAIL() << "nothing was thrown: " << message;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::usage);
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
  }
}

const BoxSet kBoxes(std::vector<Box>{{0, 0, 0, 2, 2, 2}, {1, 1, 1, 3, 3, 3}});

TEST(Misuse, LabelsOfAnotherSizeThanTheVolume) {
  const Volume volume(VoxelGrid{.size = {4, 3, 2}});
  for (const std::size_t size : {0u, 23u, 25u}) {
    std::vector<std::uint32_t> labels(size);
    expect_usage([&] { label_voxels(volume, Connectivity::faces, labels); },
                 "a volume of 24 voxels was given " + std::to_string(size) + " labels");
  }
}

TEST(Misuse, AVolumeThatDoesNotMatchItsGrid) {
  const TemporaryFolder folder;
  const auto expect_all = [&](const Volume& volume, const std::string& message) {
    std::vector<std::uint32_t> labels(volume.inside.size());
    expect_usage([&] { label_voxels(volume, Connectivity::faces, labels); }, message);
    expect_usage([&] { voxel_boxes(stream_of(volume)); }, message);
    expect_usage([&] { transposed(volume); }, message);
  };
  Volume volume(VoxelGrid{.size = {4, 3, 2}});
  volume.inside.resize(23);
  expect_all(volume, "a volume holds 23 voxels, expected the 24 of its grid");
  expect_usage(
      [&] {
        write_volume<std::uint8_t>(volume.grid, volume.inside,
                                   open_output(folder.file("a.npy"), FileUse::voxels));
      },
      "23 voxels are to be written, expected the 24 of their grid");
  EXPECT_EQ(folder.file_count(), 0u);
  volume.inside.clear();
  volume.grid.size = {std::size_t{1} << 32, std::size_t{1} << 32, 1};  // their product wraps to 0
  expect_all(volume, "a volume has 4294967296 voxels along an axis");
  volume.grid.size = {2147483647, 2147483647, 2147483647};
  expect_all(volume, "expected at most 2^60");
  volume = Volume(VoxelGrid{.size = {4, 3, 2}});
  volume.grid.axes = {0, 0, 1};
  expect_all(volume, "the axes of a volume are 0, 0 and 1");
  volume.grid.axes = {0, 1, 7};
  expect_all(volume, "the axes of a volume are 0, 1 and 7");
  expect_usage([&] { Volume{volume.grid}; }, "the axes of a volume");
}

TEST(Misuse, AStreamReadBeyondItsEnd) {
  const Volume volume(VoxelGrid{.size = {4, 3, 2}});
  const VoxelStream stream = stream_of(volume);
  std::vector<std::uint8_t> slices(24);
  stream.read(slices);
  expect_usage([&] { stream.read(std::span(slices).first(12)); },
               "more slices of a volume are read than it has");
}

TEST(Misuse, VolumesWithoutVoxels) {
  for (const std::array<std::size_t, 3>& size :
       {std::array<std::size_t, 3>{0, 5, 5}, {5, 0, 5}, {5, 5, 0}, {}}) {
    const Volume volume(VoxelGrid{.size = size});
    EXPECT_EQ(volume.inside.size(), 0u);
    EXPECT_TRUE(label_voxels(volume, Connectivity::faces, {}).empty());
    EXPECT_EQ(voxel_boxes(stream_of(volume)).size(), 0u);
    EXPECT_EQ(transposed(volume).inside.size(), 0u);
  }
}

TEST(Misuse, ANewVolumeHoldsZeros) {
  for (int round = 0; round < 3; ++round) {  // also in memory that was used before
    Volume volume(VoxelGrid{.size = {100, 200, 300}});
    EXPECT_EQ(std::ranges::count(volume.inside, 0), 6'000'000);
    std::ranges::fill(volume.inside, std::uint8_t{1});
  }
}

TEST(Misuse, OrdersThatHaveAnAxisTwice) {
  const Solid solid = unite(kBoxes, {.device = "native"});
  for (const AxisOrder order :
       {AxisOrder{0, 0, 1}, AxisOrder{0, 0, 0}, AxisOrder{1, 2, 3}, AxisOrder{255, 1, 2}}) {
    const std::string message = "the order of the axes is " + std::to_string(order[0]) + ", ";
    expect_usage([&] { make_evm(solid, order); }, message);
    expect_usage([&] { to_string(order); }, message);
    Evm evm = make_evm(solid, kAxisOrders[0]);
    expect_usage([&] { reorder(evm, order); }, message);
    evm.order = order;
    expect_usage([&] { reorder(evm, kAxisOrders[1]); }, message);
    expect_usage([&] { make_solid(evm); }, message);
    expect_usage([&] { decompose(evm, BoxModel::cudb); }, message);
    expect_usage([&] { combine(evm, evm, BooleanOperation::unite); }, message);
    Decomposition boxes = decompose(make_evm(solid, kAxisOrders[0]), BoxModel::cudb);
    const Labels labels = label_components(find_neighbors(boxes, Connectivity::faces));
    boxes.order = order;
    expect_usage([&] { to_boxes(boxes); }, message);
    expect_usage([&] { make_evm(boxes); }, message);
    expect_usage([&] { measure_components(boxes, labels); }, message);
    const TemporaryFolder folder;
    const BoxesInMemory file(kBoxes);
    Report report;
    const Options options{.device = "native"};
    ExternalUnion external(file, options, Budget{std::uint64_t{1} << 30, folder.path()}, report);
    expect_usage([&] { decompose(external, BoxModel::cudb, order, std::nullopt, std::nullopt, report); },
                 message);
  }
}

TEST(Misuse, SolidsThatDoNotMatch) {
  const Evm a = make_evm(unite(kBoxes, {.device = "native"}), kAxisOrders[0]);
  const Evm other =
      make_evm(unite(std::vector<Box>{{0, 0, 0, 1, 1, 1}}, {.device = "native"}), kAxisOrders[0]);
  expect_usage([&] { combine(a, reorder(a, kAxisOrders[1]), BooleanOperation::unite); },
               "one operand is sorted by xyz, the other by xzy");
  expect_usage([&] { combine(a, other, BooleanOperation::unite); }, "the operands have different axes");
}

TEST(Misuse, LabelsThatDoNotMatchTheBoxes) {
  const TemporaryFolder folder;
  const Decomposition boxes =
      decompose(make_evm(unite(kBoxes, {.device = "native"}), {2, 1, 0}), BoxModel::cudb);
  const Labels labels = label_components(find_neighbors(boxes, Connectivity::faces));
  for (const auto& [wrong, message] : {std::pair(Labels{{1}, 1}, std::string("were given 1 labels")),
                                       std::pair(Labels{std::vector<std::uint32_t>(boxes.boxes.size(), 2), 1},
                                                 std::string("a box has label 2, expected 1 to 1")),
                                       std::pair(Labels{std::vector<std::uint32_t>(boxes.boxes.size(), 0), 1},
                                                 std::string("a box has label 0, expected 1 to 1"))})
    expect_usage([&] { measure_components(boxes, wrong); }, message);
  for (const std::string name : {"a.csv", "a.npy"})
    expect_usage(
        [&] {
          write_labelled_boxes(to_boxes(boxes), std::vector<std::uint32_t>{1},
                               open_output(folder.file(name)));
        },
        "were given 1 labels, expected as many");
  EXPECT_EQ(folder.file_count(), 0u);
  EXPECT_EQ(label_components(Adjacency{}).count, 0u);
  EXPECT_EQ(Adjacency{}.bytes(), Adjacency::bytes_of(0, 0));
  expect_usage([&] { find_neighbors(boxes, Connectivity(18)); }, "connectivity is 18, expected 6 or 26");
  std::vector<std::uint32_t> voxels(1);
  expect_usage(
      [&] {
        label_voxels(Volume(VoxelGrid{.size = {1, 1, 1}}), Connectivity(18), voxels);
      },
      "connectivity is 18, expected 6 or 26");
}

TEST(Misuse, OptionsOutOfRange) {
  expect_usage([&] { measure(kBoxes, {.device = "native", .threads = -1}); }, "threads are -1, expected 0");
  expect_usage([&] { unite(kBoxes, {.device = "native", .threads = std::numeric_limits<int>::min()}); },
               "threads are -2147483648");
  const auto volume = [](const Tuning& tuning, Method method) {
    return measure(kBoxes, {.method = method, .device = "native", .tuning = tuning}).volume;
  };
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  for (const std::uint32_t value : {1u, 3u, 1u << 20, 1u << 31, kMost}) {
    EXPECT_EQ(volume({.cell = value}, Method::cells), 15) << value;
    EXPECT_EQ(volume({.cell_boxes = value}, Method::cells), 15) << value;
    EXPECT_EQ(volume({.tile_coordinates = value}, Method::slices), 15) << value;
    EXPECT_EQ(volume({.workgroup = value}, Method::cells), 15) << value;
  }
  EXPECT_EQ(measure(kBoxes, {.device = "native", .threads = std::numeric_limits<int>::max()}).volume, 15);
}

/// A million operands take about a hundred times as long as ten thousand.
TEST(Misuse, LongExpressionsTakeLinearTime) {
  const auto repeated = [](const std::string& text, std::size_t count) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) all += text;
    return all;
  };
  constexpr std::size_t kMany = 1'000'000;
  const auto start = std::chrono::steady_clock::now();
  const auto steps = [](const std::string& text) { return Expression::parse(text).steps().size(); };
  EXPECT_EQ(steps(repeated("a not (", kMany) + "b" + repeated(")", kMany)), 2 * kMany + 1);
  EXPECT_EQ(steps(repeated("(", kMany) + "a" + repeated(" xor b)", kMany)), 2 * kMany + 1);
  EXPECT_EQ(steps("a" + repeated(" or b and c", kMany)), 4 * kMany + 1);
  EXPECT_EQ(steps(repeated("(", kMany) + "a" + repeated(")", kMany)), 1u);
  expect_usage([&] { steps(repeated("(", kMany)); },
               "expression, column 1000001: expected a name or '(', found the end");
  expect_usage([&] { steps("a" + repeated(")", kMany)); }, "expression, column 2: ')' without '('");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));  // quadratic: hours
}

}  // namespace
}  // namespace boxunion

// Values known from other sources, and files that must be the same to the byte.

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>

#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "host/files/files.hpp"
#include "tests/device/every_device.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

class KnownValues : public EveryDevice {
 protected:
  /// Measures by cells, and checks that slices give the same.
  MassProperties measure(const BoxSet& boxes) const {
    const MassProperties mass = boxunion::measure(boxes, {.method = Method::cells, .device = GetParam()});
    EXPECT_EQ(boxunion::measure(boxes, {.method = Method::slices, .device = GetParam()}), mass);
    return mass;
  }
};
INSTANTIATE_TEST_SUITE_P(Devices, KnownValues, testing::ValuesIn(device_ids()), device_name);

TEST_P(KnownValues, MengerSponge) {
  const MassProperties mass = measure(collect(generate_sponge(3)));
  EXPECT_EQ(mass.volume, 8000);
  EXPECT_EQ(mass.area, 18048);
  EXPECT_EQ(mass.edge_length, 22512);
  EXPECT_EQ(mass.vertices, 7912u);
  EXPECT_EQ(mass.extreme_vertices, 4544u);
  EXPECT_EQ(mass.centroid, (std::array{13.5, 13.5, 13.5}));
}

TEST_P(KnownValues, Checkerboard) {
  const MassProperties mass = measure(collect(generate_checkerboard(20)));
  EXPECT_EQ(mass.volume, 4000);
  EXPECT_EQ(mass.area, 24000);
  EXPECT_EQ(mass.vertices, 9257u);
  EXPECT_EQ(mass.extreme_vertices, 232u);
}

/// A row of standard cells: layout rectangles with decimal coordinates.
TEST_P(KnownValues, StandardCells) {
  const std::string path = BOXUNION_DATA "/sky130_hd_row.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path << "; see BOXUNION_DATA";
  const MassProperties mass = measure(read_boxes(path));
  EXPECT_EQ(mass.volume, 1753.3390718200017);
  EXPECT_EQ(mass.area, 24991.554191999996);
  EXPECT_EQ(mass.edge_length, 111750.24320000003);
  EXPECT_EQ(mass.vertices, 117690u);
  EXPECT_EQ(mass.extreme_vertices, 117682u);
}

/// Boxes that overlap, touch and coincide, with corners on tenths: three ranked axes.
BoxSet tenths() {
  std::mt19937 random(11);
  std::vector<Box> boxes(300);
  for (Box& box : boxes)
    for (unsigned a = 0; a < 3; ++a) {
      const int lo = int(random() % 50);
      box[a] = 0.1 * lo;
      box[a + 3] = 0.1 * (lo + int(random() % 12));
    }
  return boxes;
}

TEST_P(KnownValues, VertexFilesAreTheSameToTheByteHoweverTheyAreMade) {
  const TemporaryFolder folder;
  const auto files = [&](const BoxSet& boxes, const Options& options) {
    const Solid solid = unite(boxes, options);
    std::string both;
    for (const char* name : {"v.csv", "v.npy"}) {
      write_vertices(solid, open_output(folder.file(name)));
      both += folder.read(name);
    }
    return both;
  };
  for (const BoxSet& boxes : {tenths(), BoxSet(collect(generate_cubes(400, 12, 100, 5)))}) {
    const std::string expected = files(boxes, {.device = "native", .threads = 1});
    EXPECT_GT(expected.size(), 10'000u);
    for (const int threads : {1, 2, 8})
      EXPECT_EQ(files(boxes, {.device = GetParam(), .threads = threads}), expected) << threads << " threads";
    for (const std::uint32_t workgroup : {1u, 8u, 32u})
      for (const Shape shape : {Shape::group, Shape::item})
        for (const std::uint32_t size : {2u, 7u, 31u}) {
          Options options{.method = Method::slices,
                          .device = GetParam(),
                          .tuning = {.shape = shape, .workgroup = workgroup, .tile_coordinates = size}};
          const std::string launch = (shape == Shape::group ? "group " : "item ") + std::to_string(workgroup);
          EXPECT_EQ(files(boxes, options), expected) << launch << ", tiles of " << size;
          options.method = Method::cells;
          options.tuning = {.shape = shape, .workgroup = workgroup, .cell = size};
          EXPECT_EQ(files(boxes, options), expected) << launch << ", cells of " << size;
        }
  }
}

}  // namespace
}  // namespace boxunion

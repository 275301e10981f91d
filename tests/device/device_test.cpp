#include "host/device/device.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>
#include <random>
#include <thread>

#include "boxunion/error.hpp"
#include "host/device/backend.hpp"
#include "host/device/kernels.hpp"
#include "kernels/contract.h"
#include "tests/device/every_device.hpp"

namespace boxunion {
namespace {

using Words = std::vector<std::uint32_t>;
using Vertices = std::vector<std::array<std::uint32_t, 3>>;

/// Tiles in the form that kernels/contour.k reads.
struct Tiles {
  Words tile, rectangle;
  std::uint32_t count() const { return static_cast<std::uint32_t>(tile.size() / CONTOUR_TILE_WORDS); }
  void add(std::array<std::uint32_t, 4> bounds, const std::vector<std::array<std::uint32_t, 4>>& rectangles) {
    tile.insert(tile.end(), bounds.begin(), bounds.end());
    tile.push_back(static_cast<std::uint32_t>(rectangle.size() / CONTOUR_RECTANGLE_WORDS));
    tile.push_back(static_cast<std::uint32_t>(rectangles.size()));
    for (const auto& r : rectangles) rectangle.insert(rectangle.end(), r.begin(), r.end());
  }
};

/// The result of contour for a tile: its sorted vertices, or that it was crowded.
struct Contour {
  bool crowded = false;
  Vertices vertices;
  bool operator==(const Contour&) const = default;
  friend void PrintTo(const Contour& contour, std::ostream* out) {
    *out << (contour.crowded ? "crowded " : "") << testing::PrintToString(contour.vertices);
  }
};

struct Result {
  std::uint32_t total = 0;
  Words vertex;  // the whole buffer
  std::vector<Contour> contours;
};

constexpr std::uint32_t untouched = 0xabcdabcdu;

std::unique_ptr<Buffer> upload(Device& device, const Words& words) {
  auto buffer = device.allocate(words.size() * sizeof words[0]);
  std::copy(words.begin(), words.end(), buffer->view<std::uint32_t>().begin());
  device.upload(*buffer, buffer->bytes());
  return buffer;
}

/// Runs contour with an output buffer of `slots` vertices, of which the kernel may use `capacity`.
Result run_contour(Device& device, Shape shape, std::uint32_t workgroup, const Tiles& tiles,
                   std::uint32_t capacity, std::uint32_t slots) {
  const auto kernel = device.load(kernels::contour(), shape, workgroup);
  const auto tile = upload(device, tiles.tile), rectangle = upload(device, tiles.rectangle);
  const auto found = device.allocate(8u * tiles.count());
  const auto vertex = upload(device, Words(3u * slots, untouched));
  const auto total = device.allocate(8);
  device.clear(*total, 8);
  std::ranges::fill(total->view<std::uint32_t>(), 0u);
  device.upload(*total, 8);  // once more: to oclgrind 21.10, clear initializes nothing
  const std::array<Buffer*, 5> buffers{tile.get(), rectangle.get(), found.get(), vertex.get(), total.get()};
  const std::array<std::uint32_t, 3> parameters{tiles.count(), capacity, 2};
  device.dispatch(*kernel, buffers, std::as_bytes(std::span(parameters)), tiles.count());
  for (Buffer* output : {found.get(), vertex.get(), total.get()})
    device.download(*output, 0, output->bytes());
  device.wait();

  Result result;
  result.total = total->view<std::uint32_t>()[0];
  const auto words = vertex->view<std::uint32_t>();
  result.vertex.assign(words.begin(), words.end());
  for (std::uint32_t t = 0; t < tiles.count(); ++t) {
    const std::uint32_t first = found->view<std::uint32_t>()[2 * t],
                        n = found->view<std::uint32_t>()[2 * t + 1];
    Contour contour{.crowded = n == CONTOUR_CROWDED, .vertices = {}};
    if (!contour.crowded && first + n <= capacity)
      for (std::uint32_t v = first; v < first + n; ++v)
        contour.vertices.push_back({words[3 * v], words[3 * v + 1], words[3 * v + 2]});
    std::sort(contour.vertices.begin(), contour.vertices.end());
    result.contours.push_back(std::move(contour));
  }
  return result;
}

Result run_contour(Device& device, Shape shape, std::uint32_t workgroup, const Tiles& tiles) {
  const std::uint32_t slots = tiles.count() * 64 + 1024;
  return run_contour(device, shape, workgroup, tiles, slots, slots);
}

/// A lone square, two that overlap, two that touch at a corner, a tile inside a rectangle, an empty tile, a
/// crowded one, and random ones.
Tiles some_tiles() {
  Tiles tiles;
  tiles.add({0, 0, 100, 100}, {{10, 10, 20, 20}});
  tiles.add({0, 0, 100, 100}, {{10, 10, 20, 20}, {15, 15, 30, 30}});
  tiles.add({0, 0, 100, 100}, {{10, 10, 20, 20}, {20, 20, 30, 30}});
  tiles.add({10, 10, 20, 20}, {{5, 5, 30, 30}});
  tiles.add({0, 0, 100, 100}, {});
  std::vector<std::array<std::uint32_t, 4>> diagonal;
  for (std::uint32_t i = 0; i < 40; ++i) diagonal.push_back({2 * i, 2 * i, 2 * i + 1, 2 * i + 1});
  tiles.add({0, 0, 100, 100}, diagonal);
  std::mt19937 generator(1);
  const auto random = [&](std::uint32_t n) { return static_cast<std::uint32_t>(generator() % n); };
  for (int t = 0; t < 30; ++t) {
    std::vector<std::array<std::uint32_t, 4>> rectangles;
    for (int i = 0; i < 12; ++i) {
      const std::uint32_t x = random(28), y = random(28), w = 1 + random(8), h = 1 + random(8);
      if (x < 24 && x + w >= 8 && y < 24 && y + h >= 8) rectangles.push_back({x, y, x + w, y + h});
    }
    tiles.add({8, 8, 24, 24}, rectangles);
  }
  return tiles;
}

struct Choice {
  std::string id;
  ZeroCopy zero_copy;
  friend void PrintTo(const Choice& choice, std::ostream* out) { *out << choice.id; }
};

std::vector<Choice> choices() {
  std::vector<Choice> all;
  for (const DeviceInfo& device : devices_under_test()) {
    all.push_back({device.id, ZeroCopy::where_possible});
    if (device.is_unified && device.id != "native") all.push_back({device.id, ZeroCopy::never});
  }
  return all;
}

class DeviceTest : public testing::TestWithParam<Choice> {
 protected:
  std::unique_ptr<Device> device = open_device(GetParam().id, GetParam().zero_copy);
};

INSTANTIATE_TEST_SUITE_P(Devices, DeviceTest, testing::ValuesIn(choices()), [](const auto& info) {
  std::string name = info.param.id + (info.param.zero_copy == ZeroCopy::never ? "_staged" : "");
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
});

TEST_P(DeviceTest, DescribesItself) {
  const DeviceInfo& info = device->info();
  EXPECT_EQ(info.id, GetParam().id);
  EXPECT_FALSE(info.name.empty());
  EXPECT_FALSE(info.driver.empty());
  EXPECT_GT(info.max_buffer_bytes, 1u << 20);
  EXPECT_GT(info.memory_bytes, 1u << 20);
  EXPECT_LE(info.preferred_workgroup, info.max_workgroup);
}

TEST_P(DeviceTest, DownloadGivesWhatUploadBrought) {
  const std::size_t words = 100'003;
  const auto buffer = device->allocate(words * 4);
  const auto view = buffer->view<std::uint32_t>();
  std::iota(view.begin(), view.end(), 7u);
  device->upload(*buffer, buffer->bytes());
  device->wait();
  if (!device->info().is_unified) std::fill(view.begin(), view.end(), 0u);
  device->download(*buffer, 400, 4000);
  device->wait();
  for (std::size_t i = 100; i < 1100; ++i) ASSERT_EQ(view[i], i + 7);
  if (!device->info().is_unified) {
    EXPECT_EQ(view[99], 0u);  // only the requested part
    EXPECT_EQ(view[1100], 0u);
  }
}

TEST_P(DeviceTest, ClearZeroesItsRangeOnly) {
  const auto buffer = upload(*device, Words(1000, 5u));
  device->clear(*buffer, 400);
  device->download(*buffer, 0, buffer->bytes());
  device->wait();
  for (std::size_t i = 0; i < 1000; ++i) ASSERT_EQ(buffer->view<std::uint32_t>()[i], i < 100 ? 0u : 5u);
}

TEST_P(DeviceTest, BuffersAreUsedAgain) {
  for (std::uint32_t round = 0; round < 3; ++round) {
    const auto buffer = device->allocate(64);
    for (std::uint32_t value = 0; value < 3; ++value) {
      std::ranges::fill(buffer->view<std::uint32_t>(), value);
      device->upload(*buffer, 64);
      device->download(*buffer, 0, 64);
      device->wait();
      ASSERT_EQ(buffer->view<std::uint32_t>()[15], value);
    }
  }
}

TEST_P(DeviceTest, EveryShapeAndWorkgroupFindsTheSameVertices) {
  const Tiles tiles = some_tiles();
  const Result expected = run_contour(*open_device("native"), Shape::item, 1, tiles);
  ASSERT_EQ(expected.contours[0].vertices.size(), 4u);
  ASSERT_EQ(expected.contours[1].vertices.size(), 8u);
  ASSERT_EQ(expected.contours[2].vertices.size(), 7u);
  ASSERT_TRUE(expected.contours[3].vertices.empty());
  ASSERT_TRUE(expected.contours[4].vertices.empty());
  ASSERT_TRUE(expected.contours[5].crowded);
  for (const Shape shape : {Shape::group, Shape::item})
    for (const std::uint32_t workgroup : {1u, 8u, 32u}) {
      SCOPED_TRACE((shape == Shape::group ? "group " : "item ") + std::to_string(workgroup));
      const Result result = run_contour(*device, shape, workgroup, tiles);
      EXPECT_EQ(result.total, expected.total);
      for (std::size_t i = 3u * result.total; i < result.vertex.size(); ++i)
        ASSERT_EQ(result.vertex[i], untouched) << "word " << i;
      for (std::uint32_t t = 0; t < tiles.count(); ++t)
        ASSERT_EQ(result.contours[t], expected.contours[t]) << "tile " << t;
    }
  EXPECT_GT(device->kernel_seconds(), 0);
}

TEST_P(DeviceTest, RunsMoreUnitsThanAGridRowHolds) {
  Tiles tiles;
  for (int i = 0; i < 70'001; ++i) tiles.add({0, 0, 10, 10}, {});
  tiles.add({0, 0, 10, 10}, {{1, 2, 3, 4}});
  for (const Shape shape : {Shape::group, Shape::item}) {
    const Result result = run_contour(*device, shape, 1, tiles);
    EXPECT_EQ(result.total, 4u);
    EXPECT_EQ(result.contours.back().vertices.size(), 4u);
    EXPECT_TRUE(result.contours[70'000].vertices.empty());
  }
}

TEST_P(DeviceTest, OverflowLeavesMemoryPastTheCapacityAlone) {
  const Tiles tiles = some_tiles();
  const Result result = run_contour(*device, Shape::group, 8, tiles, 10, 4096);
  EXPECT_GT(result.total, 10u);
  for (std::size_t i = 30; i < result.vertex.size(); ++i) ASSERT_EQ(result.vertex[i], untouched);
}

TEST_P(DeviceTest, ManyDispatchesBeforeOneWait) {
  Tiles tiles;
  tiles.add({0, 0, 10, 10}, {{1, 2, 3, 4}});
  const auto kernel = device->load(kernels::contour(), Shape::item, 1);
  const auto tile = upload(*device, tiles.tile), rectangle = upload(*device, tiles.rectangle);
  const auto found = device->allocate(8), vertex = device->allocate(12), total = device->allocate(8);
  device->clear(*total, 8);
  const std::array<Buffer*, 5> buffers{tile.get(), rectangle.get(), found.get(), vertex.get(), total.get()};
  const std::array<std::uint32_t, 3> parameters{1, 1, 2};
  for (int i = 0; i < 600; ++i) device->dispatch(*kernel, buffers, std::as_bytes(std::span(parameters)), 1);
  device->download(*total, 0, 4);
  device->wait();
  EXPECT_EQ(total->view<std::uint32_t>()[0], 2400u);
}

TEST_P(DeviceTest, SeveralThreadsOpenItAtOnce) {
  const Tiles tiles = some_tiles();
  const Result expected = run_contour(*open_device("native"), Shape::item, 1, tiles);
  std::vector<int> same(4);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < same.size(); ++t)
    threads.emplace_back([&, t] {
      for (int round = 0; round < 20; ++round) {
        const auto own = open_device(GetParam().id, GetParam().zero_copy);
        same[t] += run_contour(*own, Shape::item, 1u << t, tiles).contours == expected.contours;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(same, std::vector<int>(4, 20));
}

TEST_P(DeviceTest, BuffersOutliveTheDeviceAndWorkInFlight) {
  auto buffer = upload(*device, Words(1000, 1u));
  const auto other = upload(*device, Words(1000, 2u));
  device->download(*buffer, 0, 4000);
  buffer.reset();
  device.reset();
}

TEST_P(DeviceTest, DestroyingABufferLosesNoWorkOnOthers) {
  const auto kept = upload(*device, Words(100, 3u));
  upload(*device, Words(100, 4u)).reset();  // waits, so that the view may be read
  if (!device->info().is_unified) std::ranges::fill(kept->view<std::uint32_t>(), 0u);
  device->download(*kept, 0, 400);
  device->wait();
  EXPECT_EQ(kept->view<std::uint32_t>()[99], 3u);
}

TEST_P(DeviceTest, RefusesWhatItCannotDo) {
  const auto kernel = device->load(kernels::contour(), Shape::item, 1);
  EXPECT_THROW(device->dispatch(*kernel, {}, {}, 1), Error);
  EXPECT_THROW(device->allocate(device->info().max_buffer_bytes + 1), Error);
  if (GetParam().id == "native") return;
  EXPECT_THROW(device->load(kernels::contour(), Shape::group, 0), Error);
  EXPECT_THROW(device->load(kernels::contour(), Shape::group, device->info().max_workgroup + 1), Error);
}

TEST(Devices, NativeIsFirst) {
  EXPECT_EQ(list_devices().front().id, "native");
}

TEST(Devices, AutoOpensAGpuOrNative) {
  const auto device = open_device("auto");
  EXPECT_TRUE(device->info().id == "native" || !device->info().is_cpu);
}

TEST(Devices, AKindOpensItsFirstDevice) {
  for (const DeviceInfo& info : list_devices())
    if (info.id.ends_with(":0")) {
      EXPECT_EQ(open_device(info.id.substr(0, info.id.size() - 2))->info().id, info.id);
    }
}

TEST(Devices, AnUnknownNameListsTheDevices) {
  for (const char* id : {"", "cuda", "opencl:99", "vulkan:99", "opencl:", "native:1", "opencl:-1"}) try {
      open_device(id);
      FAIL() << id;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::device);
      EXPECT_NE(std::string(error.what()).find("native"), std::string::npos) << error.what();
    }
}

TEST(Devices, ABackEndWithoutDevicesLeavesANote) {
  std::vector<std::string> notes;
  const auto devices = list_devices(&notes);
  for (const auto& [kind, id] : {std::pair{"OpenCL: ", "opencl:0"}, std::pair{"Vulkan: ", "vulkan:0"}})
    if (std::ranges::find(devices, id, &DeviceInfo::id) == devices.end()) {
      EXPECT_TRUE(
          std::ranges::any_of(notes, [&](const std::string& note) { return note.starts_with(kind); }));
    }
}

/// Sets an environment variable for a scope.
class ScopedEnvironment {
 public:
  ScopedEnvironment(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  ~ScopedEnvironment() { unsetenv(name_); }

 private:
  const char* name_;
};

TEST_P(DeviceTest, InjectedFailuresSurface) {
  if (GetParam().id == "native") GTEST_SKIP() << "only other devices fail on demand";
  Tiles tiles;
  tiles.add({0, 0, 10, 10}, {{1, 2, 3, 4}});
  for (const char* call :
       {"allocate:2", "upload:1", "download:3", "clear:1", "load:1", "dispatch:1", "wait:1"}) {
    SCOPED_TRACE(call);
    const ScopedEnvironment failure("BOXUNION_FAIL_DEVICE", call);
    const auto failing = open_device(GetParam().id, GetParam().zero_copy);
    try {
      run_contour(*failing, Shape::item, 8, tiles);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::device);
      EXPECT_NE(std::string(error.what()).find("injected"), std::string::npos);
    }
    EXPECT_EQ(run_contour(*failing, Shape::item, 8, tiles).total, 4u);  // fails only once
  }
}

TEST(Devices, AMalformedFailureIsAUsageError) {
  for (const DeviceInfo& info : list_devices()) {
    if (info.id == "native") continue;
    const ScopedEnvironment failure("BOXUNION_FAIL_DEVICE", "dispatch");
    EXPECT_THROW(open_device(info.id), Error);
    return;
  }
}

}  // namespace
}  // namespace boxunion

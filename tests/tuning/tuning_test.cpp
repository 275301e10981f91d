// Tuned launches: the file, the order of precedence, and that a kernel gets the chosen launch.

#include "host/tuning/tuning.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <memory>
#include <string>
#include <vector>

#include "boxunion/generate.hpp"
#include "host/engine/cell_stage.hpp"
#include "host/engine/contour_stage.hpp"
#include "tests/device/every_device.hpp"
#include "tests/device/native_proxy.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

DeviceInfo gpu(const std::string& name) {
  DeviceInfo info;
  info.id = "opencl:0";
  info.name = name;
  info.driver = "driver 1";
  info.is_cpu = false;
  info.max_workgroup = 256;
  info.preferred_shape = Shape::group;
  info.preferred_workgroup = 64;
  return info;
}

constexpr Launch kTuned{Shape::item, 32};

std::shared_ptr<const TunedLaunches> tuned(const DeviceInfo& device, Launch launch,
                                           const std::string& kernel = "contour") {
  auto launches = std::make_shared<TunedLaunches>();
  launches->set(device, kernel, launch);
  return launches;
}

TEST(Tuning, OptionsComeFirstThenTheFileThenTheDevice) {
  const DeviceInfo device = gpu("a");
  const auto file = tuned(device, kTuned);
  EXPECT_EQ(choose_launch(device, "contour", {}), (Launch{Shape::group, 64}));
  EXPECT_EQ(choose_launch(device, "contour", {.tuned = file}), kTuned);
  EXPECT_EQ(choose_launch(device, "contour", {.workgroup = 8, .tuned = file}), (Launch{Shape::item, 8}));
  EXPECT_EQ(choose_launch(device, "contour", {.shape = Shape::item, .tuned = file}), kTuned);
  EXPECT_EQ(choose_launch(device, "contour", {.shape = Shape::group, .tuned = file}),
            (Launch{Shape::group, 64}));
}

TEST(Tuning, HoldsForItsDeviceDriverAndKernelOnly) {
  DeviceInfo device = gpu("a");
  const auto file = tuned(device, kTuned);
  EXPECT_EQ(file->find(device, "contour"), kTuned);
  EXPECT_FALSE(file->find(device, "cell_occupancy"));
  EXPECT_FALSE(file->find(gpu("b"), "contour"));
  device.driver = "driver 2";
  EXPECT_FALSE(file->find(device, "contour"));
}

TEST(Tuning, UnsupportedWorkgroupsAreIgnored) {
  DeviceInfo device = gpu("a");
  const Launch usual{Shape::group, 64};
  EXPECT_EQ(choose_launch(device, "contour", {.tuned = tuned(device, {Shape::item, 257})}), usual);
  EXPECT_EQ(choose_launch(device, "contour", {.tuned = tuned(device, {Shape::group, 256})}), usual);
  EXPECT_EQ(choose_launch(device, "contour", {.tuned = tuned(device, {Shape::item, 256})}),
            (Launch{Shape::item, 256}));
}

TEST(Tuning, FilesReadBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  const std::string path = folder.file("new/folder/tuning.json");
  TunedLaunches launches;
  launches.set(gpu("a \"quoted\" name"), "contour", kTuned);
  launches.set(gpu("a \"quoted\" name"), "cell_faces", {Shape::group, 128});
  launches.set(gpu("b"), "contour", {Shape::group, 8});
  launches.write(open_tuning_file(path));
  const auto fail = [](const std::string& warning) { ADD_FAILURE() << warning; };
  const TunedLaunches read = TunedLaunches::read(path, fail);
  EXPECT_EQ(read.find(gpu("a \"quoted\" name"), "contour"), kTuned);
  EXPECT_EQ(read.find(gpu("a \"quoted\" name"), "cell_faces"), (Launch{Shape::group, 128}));
  EXPECT_EQ(read.find(gpu("b"), "contour"), (Launch{Shape::group, 8}));
  EXPECT_FALSE(TunedLaunches::read(folder.file("none.json"), fail).find(gpu("b"), "contour"));
}

TEST(Tuning, BrokenAndForeignFilesCostAWarning) {
  const TemporaryFolder folder;
  const auto device = [](const std::string& rest) {
    return R"({"format": "boxunion tuning 1", "devices": [)" + rest + "]}";
  };
  const auto kernels = [&](const std::string& entries) {
    return device(R"({"name": "a", "driver": "driver 1", "kernels": {)" + entries + "}}");
  };
  for (const std::string& text :
       {std::string(), std::string("{\"format\": "), std::string("[1, 2]"), std::string("{}"),
        std::string("\xff\xfe"), std::string(R"({"format": "other", "devices": []})"),
        std::string(R"({"format": 7, "devices": []})"),
        std::string(R"({"format": "boxunion tuning 1", "devices": 3})"), device("3"),
        device(R"({"name": "a", "driver": 1, "kernels": {}})"), kernels(R"("contour": 3)"),
        kernels(R"("contour": {"shape": "round", "workgroup": 8})"),
        kernels(R"("contour": {"shape": 1, "workgroup": 8})"),
        kernels(R"("contour": {"shape": "item", "workgroup": 0})"),
        kernels(R"("contour": {"shape": "item", "workgroup": -8})"),
        kernels(R"("contour": {"shape": "item", "workgroup": 1e9})"),
        kernels(R"("contour": {"shape": "item", "workgroup": 99999999999})"),
        kernels(R"("contour": {"shape": "item"})")}) {
    SCOPED_TRACE(text);
    std::vector<std::string> warnings;
    const auto warn = [&](const std::string& line) { warnings.push_back(line); };
    const std::string path = folder.write("tuning.json", text);
    EXPECT_FALSE(TunedLaunches::read(path, warn).find(gpu("a"), "contour"));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with(path + ": ")) << warnings[0];
  }
  std::vector<std::string> warnings;
  TunedLaunches::read(folder.path(), [&](const std::string& line) { warnings.push_back(line); });
  EXPECT_EQ(warnings.size(), 1u);
  const std::string half = kernels(R"("cell_faces": 3, "contour": {"shape": "item", "workgroup": 32})");
  EXPECT_EQ(TunedLaunches::read(folder.write("half.json", half), {}).find(gpu("a"), "contour"), kTuned);
}

TEST(Tuning, TheEnvironmentSaysWhereTheFileIs) {
  const auto get = [](const char* name) {
    const char* value = ::getenv(name);
    return value ? std::optional<std::string>(value) : std::nullopt;
  };
  const auto restore = [](const char* name, const std::optional<std::string>& value) {
    value ? ::setenv(name, value->c_str(), 1) : ::unsetenv(name);
  };
  const auto tuning = get("BOXUNION_TUNING"), config = get("XDG_CONFIG_HOME"), home = get("HOME");
  ::setenv("BOXUNION_TUNING", "some/file", 1);
  ::setenv("XDG_CONFIG_HOME", "/config", 1);
  ::setenv("HOME", "/home/me", 1);
  EXPECT_EQ(tuning_path(), "some/file");
  ::setenv("BOXUNION_TUNING", "", 1);
  EXPECT_EQ(tuning_path(), "");
  ::unsetenv("BOXUNION_TUNING");
  EXPECT_EQ(tuning_path(), "/config/boxunion/tuning.json");
  ::setenv("XDG_CONFIG_HOME", "relative", 1);
  EXPECT_EQ(tuning_path(), "/home/me/.config/boxunion/tuning.json");
  ::unsetenv("HOME");
  EXPECT_EQ(tuning_path(), "");
  restore("BOXUNION_TUNING", tuning);
  restore("XDG_CONFIG_HOME", config);
  restore("HOME", home);
}

/// The native device under another name, which records how kernels are loaded.
class NotingDevice final : public NativeProxy {
 public:
  const DeviceInfo& info() const override { return info_; }
  std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
    loaded.emplace_back(source.name, Launch{shape, workgroup});
    return NativeProxy::load(source, shape, workgroup);
  }

  std::vector<std::pair<std::string, Launch>> loaded;

 private:
  DeviceInfo info_ = gpu("a");
};

TEST(Tuning, StagesLaunchTheirKernelsAsTuned) {
  NotingDevice device;
  const Tuning tuning{.tuned = tuned(device.info(), kTuned)};
  const ContourStage contour(device, tuning);
  CellSink sink;
  const CellStage cells(device, {.tuning = tuning}, sink);
  ASSERT_EQ(device.loaded.size(), 2u);
  EXPECT_EQ(device.loaded[0], (std::pair{std::string("contour"), kTuned}));
  EXPECT_EQ(device.loaded[1], (std::pair{std::string("cell_occupancy"), Launch{Shape::group, 64}}));
}

class TunedDevice : public EveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, TunedDevice, testing::ValuesIn(device_ids()), device_name);

TEST_P(TunedDevice, GivesTheSameResult) {
  const BoxSet boxes = collect(generate_boxes(200, 1, 40, 100, 1));
  const MassProperties expected = measure(boxes, {.device = "native"});
  const DeviceInfo info = open_device(GetParam())->info();
  for (const Launch launch : {Launch{Shape::item, 3}, Launch{Shape::item, 1000}}) {
    auto launches = std::make_shared<TunedLaunches>();
    for (const char* kernel : {"contour", "cell_occupancy_sums"}) launches->set(info, kernel, launch);
    std::vector<std::string> warnings;
    Options options{.device = GetParam(), .tuning = {.tuned = launches}};
    options.warn = [&](const std::string& line) { warnings.push_back(line); };
    for (const Method method : {Method::cells, Method::slices}) {
      options.method = method;
      EXPECT_EQ(measure(boxes, options), expected);
    }
    EXPECT_TRUE(warnings.empty()) << warnings[0];
  }
}

}  // namespace
}  // namespace boxunion

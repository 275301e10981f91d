// Benchmarks of the kernels: cases are checked, failures are skipped, and times are evaluated correctly.
// Speed itself is not tested.

#include "host/bench/kernel_bench.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "boxunion/error.hpp"
#include "host/bench/bench_json.hpp"
#include "host/bench/bench_problem.hpp"
#include "tests/device/every_device.hpp"
#include "tests/device/native_proxy.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

const auto kNobody = [](const BenchDevice&, const BenchCase&) {};

class KernelBench : public EveryDevice {
 protected:
  ~KernelBench() override { ::unsetenv("BOXUNION_FAIL_DEVICE"); }
};
INSTANTIATE_TEST_SUITE_P(Devices, KernelBench, testing::ValuesIn(device_ids()), device_name);

TEST_P(KernelBench, RunsEveryKernelAndDensity) {
  std::size_t done = 0;
  const BenchResults results = run_kernel_bench({.devices = {GetParam()}, .sizes = {64}, .repetitions = 2},
                                                [&](const BenchDevice& device, const BenchCase& c) {
                                                  EXPECT_EQ(device.info.id, c.device);
                                                  ++done;
                                                });
  ASSERT_EQ(results.devices.size(), 1u);
  EXPECT_GT(results.devices[0].copy_bytes_per_second(), 0);
  EXPECT_GT(results.devices[0].dispatch_seconds.median, 0);
  EXPECT_EQ(results.cases.size(), 3 * benchmark_kernels().size());
  EXPECT_EQ(done, results.cases.size());
  std::vector<std::string> names;
  for (const BenchCase& c : results.cases) {
    SCOPED_TRACE(c.name());
    names.push_back(c.name());
    if (c.error.find("ran natively") != c.error.npos) continue;  // llvmpipe ends long loops early
    EXPECT_EQ(c.error, "");
    ASSERT_EQ(c.runs.size(), 2u);
    EXPECT_GT(c.cells, 0u);
    EXPECT_GE(c.boxes, c.cells);
    EXPECT_GT(c.vertices, 0u);
    EXPECT_GT(c.bytes_read, 4 * c.boxes);
    EXPECT_GT(c.bytes_written, 0u);
    EXPECT_GT(c.first_seconds, 0);
    for (const BenchRun& run : c.runs) {
      EXPECT_GT(run.device_seconds, 0);
      EXPECT_GT(run.wall_seconds, 0);
      EXPECT_GE(run.cpu_seconds, 0);
    }
  }
  std::ranges::sort(names);
  EXPECT_TRUE(std::ranges::adjacent_find(names) == names.end());
}

TEST_P(KernelBench, SkipsWhatFails) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const KernelBenchOptions options{.devices = {GetParam()},
                                   .kernels = {"contour", "cell_occupancy"},
                                   .densities = {Density::middle},
                                   .sizes = {64},
                                   .repetitions = 1};
  ::setenv("BOXUNION_FAIL_DEVICE", "load:2", 1);  // after the copy kernel; then the device is opened again
  BenchResults results = run_kernel_bench(options, kNobody);
  ASSERT_EQ(results.cases.size(), 2u);
  EXPECT_NE(results.cases[0].error.find("injected failure of load"), std::string::npos);
  EXPECT_TRUE(results.cases[0].runs.empty());
  EXPECT_EQ(results.cases[1].error, "");
  EXPECT_EQ(results.cases[1].runs.size(), 1u);
  ::setenv("BOXUNION_FAIL_DEVICE", "allocate:1", 1);
  results = run_kernel_bench(options, kNobody);
  EXPECT_TRUE(results.cases.empty());
  EXPECT_NE(results.devices.at(0).error.find("injected failure of allocate"), std::string::npos);
}

TEST_P(KernelBench, RunsTheRequestedLaunches) {
  if (GetParam() == "native") GTEST_SKIP() << "it knows no launches";
  const BenchResults results = run_kernel_bench({.devices = {GetParam()},
                                                 .kernels = {"contour"},
                                                 .densities = {Density::middle},
                                                 .sizes = {32},
                                                 .shapes = {Shape::item, Shape::group},
                                                 .workgroups = {4, 8, 100'000},
                                                 .repetitions = 1},
                                                kNobody);
  std::vector<std::string> launches;
  for (const BenchCase& c : results.cases) {
    launches.push_back(std::string(to_string(c.launch.shape)) + " " + std::to_string(c.launch.workgroup));
    EXPECT_EQ(c.error.empty(), c.launch.workgroup < 100) << c.name() << c.error;
  }
  EXPECT_EQ(launches, (std::vector<std::string>{"item 4", "item 8", "item 100000", "group 4", "group 8",
                                                "group 100000"}));
}

TEST(KernelBenchOptions, WrongNamesAreErrors) {
  EXPECT_THROW(run_kernel_bench({.devices = {"native"}, .kernels = {"magic"}}, kNobody), Error);
  EXPECT_THROW(run_kernel_bench({.devices = {"magic:7"}}, kNobody), Error);
}

/// The native device with one wrong bit in every result.
class WrongDevice final : public NativeProxy {
 public:
  void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
    NativeProxy::download(buffer, offset, bytes);
    if (wrong && bytes > 2 * sizeof(std::uint32_t)) buffer.view<std::uint32_t>()[offset / 4] ^= 1u;
  }

  bool wrong = true;
};

TEST(BenchProblem, WrongResultsAreNoticed) {
  for (const std::string_view kernel : benchmark_kernels()) {
    if (kernel == "contour") continue;  // its stage already rejects such a result
    SCOPED_TRACE(kernel);
    const auto problem = make_problem(std::string(kernel), Density::middle, 64);
    WrongDevice device;
    const auto runner = problem->make_runner(device, {});
    EXPECT_FALSE(runner->check());
    device.wrong = false;
    EXPECT_TRUE(runner->check());
    EXPECT_FALSE(runner->ran_natively());
  }
}

TEST(BenchProblem, IsTheSameEveryTime) {
  for (const std::string_view kernel : benchmark_kernels()) {
    const BenchCase a = make_problem(std::string(kernel), Density::dense, 100)->describe();
    const BenchCase b = make_problem(std::string(kernel), Density::dense, 100)->describe();
    EXPECT_EQ(a.kernel, kernel);
    EXPECT_EQ(a.cells, b.cells) << kernel;
    EXPECT_EQ(a.boxes, b.boxes) << kernel;
    EXPECT_EQ(a.vertices, b.vertices) << kernel;
    EXPECT_EQ(a.bytes_read, b.bytes_read) << kernel;
  }
}

TEST(Spread, IsMedianAndHalfTheInterquartileRange) {
  EXPECT_EQ(spread_of({7}).median, 7);
  EXPECT_EQ(spread_of({7}).deviation, 0);
  EXPECT_EQ(spread_of({5, 1, 2, 3, 4}).median, 3);
  EXPECT_EQ(spread_of({5, 1, 2, 3, 4}).deviation, 1);
  EXPECT_EQ(spread_of({1, 2}).median, 1.5);
}

/// Results of contour on a device, by launch, density and device seconds.
BenchResults contour_results(const std::vector<std::tuple<Launch, Density, std::vector<double>>>& measured) {
  BenchResults results;
  BenchDevice& device = results.devices.emplace_back();
  device.info.id = "opencl:0";
  device.info.preferred_shape = Shape::item;
  device.info.preferred_workgroup = 8;
  device.info.max_workgroup = 64;
  for (const auto& [launch, density, seconds] : measured) {
    BenchCase& c = results.cases.emplace_back();
    c.device = "opencl:0";
    c.kernel = "contour";
    c.size = 10;
    c.launch = launch;
    c.density = density;
    for (const double s : seconds) c.runs.push_back({s, s, s});
    if (seconds.empty()) c.error = "failed";
  }
  return results;
}

constexpr Launch kUsual{Shape::item, 8}, kOther{Shape::group, 32}, kThird{Shape::item, 64};

TEST(BestLaunches, AreTheFastestOverAllCases) {
  const auto best = best_launches(contour_results({{kUsual, Density::sparse, {4, 4, 4}},
                                                   {kUsual, Density::dense, {4, 4, 4}},
                                                   {kOther, Density::sparse, {1, 1, 1}},
                                                   {kOther, Density::dense, {4, 4, 4}},
                                                   {kThird, Density::sparse, {3, 3, 3}},
                                                   {kThird, Density::dense, {3, 3, 3}}}),
                                  nullptr);
  ASSERT_EQ(best.size(), 1u);
  EXPECT_EQ(best[0].kernel, "contour");
  EXPECT_EQ(best[0].launch, kOther);
  EXPECT_DOUBLE_EQ(best[0].gain, 2);
}

TEST(BestLaunches, KeepTheLaunchInUseWithinTheNoise) {
  const BenchResults results =
      contour_results({{kUsual, Density::sparse, {4, 5, 6}}, {kOther, Density::sparse, {4, 4.9, 6}}});
  EXPECT_EQ(best_launches(results, nullptr).at(0).launch, kUsual);
  const auto tuned = std::make_shared<TunedLaunches>();
  tuned->set(results.devices[0].info, "contour", kOther);
  EXPECT_EQ(best_launches(results, tuned).at(0).launch, kOther);
}

TEST(BestLaunches, NeverIncludeAFailedCase) {
  const auto best = best_launches(contour_results({{kUsual, Density::sparse, {4}},
                                                   {kUsual, Density::dense, {4}},
                                                   {kOther, Density::sparse, {1}},
                                                   {kOther, Density::dense, {}}}),
                                  nullptr);
  EXPECT_EQ(best.at(0).launch, kUsual);
  EXPECT_TRUE(best_launches(contour_results({{kUsual, Density::sparse, {}}}), nullptr).empty());
}

TEST(CompareBenchJson, ShowsChangesAndCasesMissingFromOneFile) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const BenchResults& results) {
    write_bench_json(results, OutputFile(folder.file(name)));
    return folder.file(name);
  };
  const std::string before = write("a.json", contour_results({{kUsual, Density::sparse, {3, 4, 5}},
                                                              {kOther, Density::sparse, {1}},
                                                              {kUsual, Density::dense, {}}}));
  const std::string after = write(
      "b.json", contour_results({{kUsual, Density::sparse, {6, 6, 6}}, {kThird, Density::sparse, {1}}}));
  const auto changes = compare_bench_json(before, after);
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(changes[0].name, "opencl:0/contour/item/8/sparse/10");
  EXPECT_DOUBLE_EQ(changes[0].change(), 0.5);
  EXPECT_DOUBLE_EQ(changes[0].noise(), 0.125 * 1.5);
  EXPECT_EQ(changes[1].name, "opencl:0/contour/group/32/sparse/10");
  EXPECT_FALSE(changes[1].after);
  EXPECT_EQ(changes[2].name, "opencl:0/contour/item/64/sparse/10");
  EXPECT_FALSE(changes[2].before);
}

TEST(CompareBenchJson, ReadsWhatGoogleBenchmarkWrites) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& unit, double time) {
    return folder.write(name,
                        R"({"context": {}, "benchmarks": [{"name": "BM_sort/8", "run_name": "BM_sort/8",
      "run_type": "iteration", "iterations": 3, "real_time": )" +
                            std::to_string(time) + R"(, "cpu_time": 1, "time_unit": ")" + unit +
                            R"("}, {"name": "BM_sort/8_mean", "run_type": "aggregate", "real_time": 99}]})");
  };
  const auto changes = compare_bench_json(write("a.json", "us", 2000), write("b.json", "ms", 1));
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].name, "BM_sort/8");
  EXPECT_DOUBLE_EQ(changes[0].change(), -0.5);
}

}  // namespace
}  // namespace boxunion

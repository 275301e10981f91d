// Failures while a union is computed: devices that fail, callers that interrupt, and lack of memory.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>
#include <string>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "core/base/interruptible.hpp"
#include "tests/device/every_device.hpp"

namespace boxunion {
namespace {

/// Boxes on two footprints, nested along z: 2 * count slabs of up to 2 * count rectangles, which a tile
/// merges to two. Little work in many batches of about a million rectangles each.
BoxSet nested(int count) {
  std::vector<IntegerBox> boxes;
  for (int i = 0; i < count; ++i) {
    boxes.push_back({0, 0, i, 2, 2, 2 * count - i});
    boxes.push_back({1, 1, i, 3, 3, 2 * count - i});
  }
  return boxes;
}
constexpr int kFourBatches = 1300, kUniverse = 32768;

class Resilience : public EveryDevice {
 protected:
  ~Resilience() override { ::unsetenv("BOXUNION_FAIL_DEVICE"); }

  /// Makes the n-th call of one kind fail on the device. The result must be the same, with one warning.
  template <class Run>
  void expect_native_fallback(Method method, const std::vector<std::string>& calls, Run&& run) {
    Report report;
    const auto expected = run(Options{.method = method, .device = "native"}, report);
    for (const std::string& call : calls) {
      SCOPED_TRACE(call);
      std::vector<std::string> warnings;
      Options options{.method = method, .device = GetParam()};
      options.warn = [&](const std::string& line) { warnings.push_back(line); };
      ::setenv("BOXUNION_FAIL_DEVICE", call.c_str(), 1);
      EXPECT_TRUE(run(options, report) == expected);
      EXPECT_EQ(report.device, "native");
      ASSERT_EQ(warnings.size(), 1u);
      EXPECT_TRUE(warnings[0].starts_with(GetParam() + " failed, continuing natively: ")) << warnings[0];
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Devices, Resilience, testing::ValuesIn(device_ids()), device_name);

TEST_P(Resilience, SlicesContinueNativelyIfTheDeviceFails) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const BoxSet boxes = nested(kFourBatches);
  expect_native_fallback(
      Method::slices,
      {"load:1", "allocate:1", "allocate:3", "clear:1", "clear:2", "upload:1", "upload:4", "dispatch:1",
       "dispatch:3", "download:1", "download:5", "wait:1", "wait:6"},
      [&](const Options& options, Report& report) { return unite(boxes, options, &report).vertices; });
}

TEST_P(Resilience, CellsContinueNativelyIfTheDeviceFails) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const BoxSet boxes = collect(generate_cubes(200'000, 60, kUniverse, 3));
  const std::vector<std::string> calls = {"load:1",     "allocate:2", "upload:1",
                                          "dispatch:1", "download:1", "wait:1"};
  expect_native_fallback(Method::cells, calls, [&](const Options& options, Report& report) {
    return unite(boxes, options, &report).vertices;
  });
  expect_native_fallback(Method::cells, calls, [&](const Options& options, Report& report) {
    return measure(boxes, options, &report);
  });
}

/// Makes the first, second, ... call of every kind fail, until a run makes fewer calls.
TEST_P(Resilience, NoFallbackEndsTheRunWhateverFails) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const BoxSet boxes = collect(generate_cubes(30, 10'000, kUniverse, 3));
  const Array<Vertex> expected = unite(boxes, {.device = "native"}).vertices;
  for (const Method method : {Method::cells, Method::slices})
    for (const std::string call : {"load", "allocate", "upload", "clear", "dispatch", "download", "wait"}) {
      int n = 1;
      for (bool failed = true; failed; ++n) {
        SCOPED_TRACE(call + ":" + std::to_string(n));
        ::setenv("BOXUNION_FAIL_DEVICE", (call + ":" + std::to_string(n)).c_str(), 1);
        Options options{.method = method, .device = GetParam(), .fallback = false};
        options.warn = [](const std::string& line) { ADD_FAILURE() << line; };
        failed = false;
        try {
          EXPECT_TRUE(unite(boxes, options).vertices == expected);
        } catch (const Error& error) {
          failed = true;
          EXPECT_EQ(error.kind(), ErrorKind::device);
          EXPECT_TRUE(std::string_view(error.what()).starts_with(GetParam() + " failed: ")) << error.what();
        }
      }
      EXPECT_GT(n, 2) << "the run makes no " << call;
    }
}

/// While the device computes one batch, the next is cut. Either may be lost.
TEST_P(Resilience, CellsLoseNoBatchIfTheDeviceFailsLater) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const BoxSet boxes = collect(generate_cubes(1'000'000, 30, kUniverse, 3));
  expect_native_fallback(
      Method::cells, {"upload:6", "dispatch:2", "download:1", "download:2", "wait:1", "wait:2"},
      [&](const Options& options, Report& report) { return measure(boxes, options, &report); });
}

TEST_P(Resilience, CombinationsLoseNoBatchEither) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const Expression expression = Expression::parse("A not B");
  const std::vector<BoxSet> sets{collect(generate_cubes(100'000, 90, kUniverse, 3)),
                                 collect(generate_cubes(100'000, 90, kUniverse, 4))};
  const std::vector<std::string> calls = {"load:1",     "upload:5",   "upload:6",
                                          "dispatch:1", "download:1", "wait:1"};
  expect_native_fallback(Method::cells, calls, [&](const Options& options, Report& report) {
    return combine(expression, sets, options, &report).vertices;
  });
  expect_native_fallback(Method::cells, calls, [&](const Options& options, Report& report) {
    return measure(expression, sets, options, &report);
  });
}

void expect_interrupted(const BoxSet& boxes, const Options& options) {
  for (const bool by_measure : {true, false}) try {
      if (by_measure)
        measure(boxes, options);
      else
        unite(boxes, options);
      ADD_FAILURE() << "not interrupted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::interrupted);
    }
}

TEST_P(Resilience, AnInterruptedRunEndsWithAnError) {
  for (const Method method : {Method::cells, Method::slices}) {
    Options options{.method = method, .device = GetParam()};
    std::atomic<bool> interrupted = true;
    options.interrupted = &interrupted;
    expect_interrupted(nested(1), options);

    interrupted = false;  // later, once some of the work is done
    options.progress = [&](double fraction) {
      EXPECT_LT(fraction, 1);
      interrupted = true;
    };
    expect_interrupted(
        method == Method::slices ? nested(kFourBatches) : collect(generate_cubes(200'000, 60, kUniverse, 3)),
        options);
  }
}

TEST_P(Resilience, ARunWatchesItsCallersFlagUnlessItHasItsOwn) {
  const std::atomic<bool> interrupted = true, goes_on = false;
  const Interruptible scope(&interrupted);
  for (const int threads : {0, 1}) {
    Options options{.device = GetParam(), .threads = threads};
    expect_interrupted(nested(1), options);
    options.interrupted = &goes_on;
    EXPECT_NO_THROW(unite(nested(1), options));
  }
}

}  // namespace
}  // namespace boxunion

// What may happen while a union is computed: devices that fail, callers that lose patience, memory that ends.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>

#include "core/error.hpp"
#include "host/engine.hpp"
#include "tests/every_device.hpp"

namespace boxunion {
namespace {

/// Boxes on two footprints, inside each other along z: 2 * count slabs of up to 2 * count rectangles, all of
/// which a tile merges to two. Little work in many batches, of about a million rectangles each.
BoxSet nested(int count) {
  std::vector<IntegerBox> boxes;
  for (int i = 0; i < count; ++i) {
    boxes.push_back({0, 0, i, 2, 2, 2 * count - i});
    boxes.push_back({1, 1, i, 3, 3, 2 * count - i});
  }
  return boxes;
}
constexpr int kFourBatches = 1300;

class Resilience : public EveryDevice {
 protected:
  ~Resilience() override { ::unsetenv("BOXUNION_FAIL_DEVICE"); }
  Options options() const { return {.method = Method::slices, .device = GetParam()}; }
};
INSTANTIATE_TEST_SUITE_P(Devices, Resilience, testing::ValuesIn(device_ids()), device_name);

TEST_P(Resilience, AFailingDeviceCostsAWarningNotTheResult) {
  if (GetParam() == "native") GTEST_SKIP() << "only other devices fail on demand";
  const BoxSet boxes = nested(kFourBatches);
  const Solid expected = unite(boxes, {.device = "native"});
  ASSERT_EQ(expected.vertices.size(), 16u);
  for (const char* call : {"load:1", "allocate:1", "allocate:3", "clear:1", "clear:2", "upload:1", "upload:4",
                           "dispatch:1", "dispatch:3", "download:1", "download:5", "wait:1", "wait:6"}) {
    SCOPED_TRACE(call);
    std::vector<std::string> warnings;
    Options options = this->options();
    options.warn = [&](const std::string& line) { warnings.push_back(line); };
    ::setenv("BOXUNION_FAIL_DEVICE", call, 1);
    Report report;
    EXPECT_EQ(unite(boxes, options, &report).vertices, expected.vertices);
    EXPECT_EQ(report.device, "native");
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with(GetParam() + " failed, going on natively: ")) << warnings[0];
  }
}

TEST_P(Resilience, AnInterruptedRunEndsWithAnError) {
  std::atomic<bool> interrupted = true;
  Options options = this->options();
  options.interrupted = &interrupted;
  const auto expect_interrupted = [&](auto&& run) {
    try {
      run();
      FAIL() << "not interrupted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::interrupted);
    }
  };
  expect_interrupted([&] { measure(nested(1), options); });
  expect_interrupted([&] { unite(nested(1), options); });

  // in the middle, after the first batch
  interrupted = false;
  int batches = 0;
  options.progress = [&](double fraction) {
    ++batches;
    EXPECT_LT(fraction, 1);
    interrupted = true;
  };
  expect_interrupted([&] { measure(nested(kFourBatches), options); });
  EXPECT_EQ(batches, 1);
}

}  // namespace
}  // namespace boxunion

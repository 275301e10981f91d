// Devices in a child made by fork(). The native device works, the others refuse, and nothing hangs.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <string>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "host/device/device.hpp"
#include "tests/device/every_device.hpp"

namespace boxunion {
namespace {

/// The exit status of `work` in a child of this process. The child must end within a minute.
int in_child(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(60);
    ::_exit(work());
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// 0 if `work` throws Error(device) that mentions the fork.
template <class Work>
int is_refused(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    const bool tells = std::string(error.what()).find("before fork()") != std::string::npos;
    return error.kind() == ErrorKind::device && tells ? 0 : 2;
  }
  return 1;
}

class Fork : public EveryDevice {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "the thread sanitizer starts no threads after fork()";
#endif
  }
};
INSTANTIATE_TEST_SUITE_P(Devices, Fork, testing::ValuesIn(device_ids()), device_name);

TEST_P(Fork, NativeWorksAndOtherDevicesRefuse) {
  const BoxSet boxes = collect(generate_cubes(30'000, 300, 32768, 3));
  const Options options{.device = GetParam(), .fallback = false};
  const MassProperties mass = measure(boxes, options);
  const auto measures = [&](const std::string& device) {
    return in_child([&] { return measure(boxes, {.device = device}) == mass ? 0 : 1; });
  };
  EXPECT_EQ(measures("native"), 0);
  EXPECT_EQ(measures("auto"), 0);
  if (GetParam() == "native") return;
  EXPECT_EQ(in_child([&] { return is_refused([&] { measure(boxes, options); }); }), 0);
  EXPECT_EQ(in_child([&] { return is_refused([&] { open_device(GetParam()); }); }), 0);
  EXPECT_EQ(in_child([] { return list_devices().front().id == "native" ? 0 : 1; }), 0);
  EXPECT_TRUE(measure(boxes, options) == mass);  // it still works in the parent
}

TEST_P(Fork, ADeviceThatWasOpenedBeforeIsRefused) {
  if (GetParam() == "native") GTEST_SKIP() << "it has no driver";
  std::unique_ptr<Device> device = open_device(GetParam());
  std::unique_ptr<Buffer> buffer = device->allocate(64);
  device->clear(*buffer, 64);
  device->wait();
  device->clear(*buffer, 64);
  const int status = in_child([&] {
    const int refused = is_refused([&] { device->allocate(64); }) + is_refused([&] { device->wait(); });
    buffer.reset();  // must not wait for the driver's threads
    device.reset();
    return refused;
  });
  EXPECT_EQ(status, 0);
  device->wait();
}

TEST(ForkThreads, AChildOfAProcessWithManyThreadsMeasuresNatively) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the thread sanitizer starts no threads after fork()";
#endif
  const BoxSet boxes = collect(generate_cubes(50'000, 100, 32768, 5));
  for (const int threads : {0, 1, 8}) {
    const MassProperties mass = measure(boxes, {.device = "native", .threads = threads});
    for (const int again : {0, 1, 8})
      EXPECT_EQ(
          in_child([&] { return measure(boxes, {.device = "native", .threads = again}) == mass ? 0 : 1; }), 0)
          << threads << " threads, in the child " << again;
  }
}

}  // namespace
}  // namespace boxunion

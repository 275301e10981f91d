// Eight threads use a driver for the first time at once, in many fresh processes. The other tests of devices
// start the drivers before they begin.

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <barrier>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "boxunion/union.hpp"
#include "host/device/device.hpp"

namespace {

using namespace boxunion;

constexpr int kRounds = 50, kThreads = 8;

/// Measures two boxes on a device by all threads at once. Some of them list the devices first. Returns the
/// exit status.
int use_at_once(const std::string& device) {
  const BoxSet boxes(std::vector<Box>{{0, 0, 0, 2, 2, 2}, {1, 1, 1, 3, 3, 3}});
  std::atomic<int> failed = 0;
  std::barrier start(kThreads);
  std::vector<std::jthread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&, i] {
      start.arrive_and_wait();
      try {
        if (i % 4 == 3) list_devices();
        const double volume = measure(boxes, {.device = device, .fallback = false}).volume;
        if (volume == 15) return;
        std::printf("%s: volume %g, expected 15\n", device.c_str(), volume);
      } catch (const std::exception& error) {
        std::printf("%s\n", error.what());
      }
      failed = 1;
    });
  threads.clear();
  return failed;
}

/// Runs this program for a device. Returns true if it succeeds.
bool succeeds(std::string device) {
  std::string name = "boxunion_first_use";
  char* const arguments[] = {name.data(), device.data(), nullptr};
  pid_t child = 0;
  int status = 0;
  return ::posix_spawn(&child, "/proc/self/exe", nullptr, nullptr, arguments, environ) == 0 &&
         ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) return use_at_once(argv[1]);
  int failures = 0;
  for (const DeviceInfo& device : list_devices()) {
    int failed = 0;
    for (int round = 0; round < kRounds; ++round) failed += !succeeds(device.id);
    std::printf("%s: %d of %d processes failed\n", device.id.c_str(), failed, kRounds);
    failures += failed;
  }
  return failures > 0;
}

#include "host/command/command_memory.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "boxunion/error.hpp"
#include "core/boxes/ordinals.hpp"
#include "host/device/device.hpp"
#include "host/engine/threads.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"

extern "C" void __asan_init() __attribute__((weak));  // NOLINT(bugprone-reserved-identifier)
extern "C" void __tsan_init() __attribute__((weak));  // NOLINT(bugprone-reserved-identifier)

namespace boxunion::command {
namespace {

/// True if sanitizers are linked, which reserve more memory than any budget. Even a command built without
/// them may be linked with a library that has them.
bool is_sanitized() {
  return __asan_init != nullptr || __tsan_init != nullptr;
}

/// Memory that RLIMIT_DATA does not count: code and constants of the process and its libraries, and the stack
/// of the first thread.
constexpr std::uint64_t kUncounted = std::uint64_t{16} << 20;
constexpr std::uint64_t kLeast = std::uint64_t{32}
                                 << 20;  // what any run takes, so that it can say that it does not suffice

/// Makes all threads work at the same time, once, so that the thread library starts them. Gives up soon if
/// the system has no time for all of them.
void start_threads(const Options& options) {
  with_threads(options, [] {
    const std::size_t all = thread_count();
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
    std::atomic<std::size_t> working = 0;
    tbb::task_group group;
    for (std::size_t i = 0; i < all; ++i)
      group.run([&] {
        ++working;
        while (working < all && std::chrono::steady_clock::now() < end) std::this_thread::yield();
      });
    group.wait();
  });
}

/// Bytes of writable private memory that the process has reserved, mostly for stacks that it never touches. 0
/// if the system does not tell.
std::uint64_t asked_for() {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key; status.ignore(1000, '\n'))
    if (std::uint64_t kibibytes = 0; key == "VmData:" && status >> kibibytes) return kibibytes << 10;
  return 0;
}

}  // namespace

void limit_memory(std::uint64_t bytes, const Options& options) {
  if (is_sanitized() || open_device(options.device)->info().id != "native") return;
  start_threads(options);
  const std::uint64_t most = asked_for() + std::max(bytes, kLeast) - kUncounted;
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, most);
  ::setrlimit(RLIMIT_DATA, &limit);  // if it fails, boxunion's own accounting remains
}

HeldBoxes::HeldBoxes(const Common& common) : common_(common) {
  if (common.budget && common.budget->bytes < kLeast)
    throw Error(ErrorKind::resources,
                fmt::format("a memory budget of {} MiB is too small: expected at least {} MiB",
                            common.budget->bytes >> 20, kLeast >> 20));
}

BoxSet HeldBoxes::read(const std::string& path) {
  if (!common_.budget) return read_boxes(path, nullptr, common_.volume);
  const std::unique_ptr<BoxFile> file = open_boxes(path, *common_.budget, common_.volume);
  const std::size_t box_bytes =
      file->read(0, 0).visit([](const auto& boxes) { return sizeof boxes[0]; }) + sizeof(OrdinalBox);
  bytes_ += file->size() * box_bytes;
  if (kUncounted + bytes_ > common_.budget->bytes)
    throw Error(ErrorKind::resources,
                fmt::format("{}: the boxes take at least {} MiB of memory, more than --memory allows", path,
                            ((kUncounted + bytes_) >> 20) + 1));
  BoxSet boxes = file->read(0, file->size());
  const std::size_t invalid = find_invalid(boxes);
  if (invalid < boxes.size()) validate(boxes[invalid], file->name_of(invalid));
  return boxes;
}

}  // namespace boxunion::command

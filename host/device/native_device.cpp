#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>

#include "boxunion/error.hpp"
#include "core/base/instruction_set.hpp"
#include "core/base/parallel.hpp"
#include "host/device/backend.hpp"
#include "host/device/kernels.hpp"

namespace boxunion {

namespace {

/// Units that a thread takes at a time: some microseconds of work, so that threads neither contend nor idle.
constexpr std::size_t grain = 16;

/// Read only once, because the system takes longer to provide it than a union of a few boxes takes.
const std::string& cpu_name() {
  static const std::string name = [] {
    std::ifstream cpuinfo("/proc/cpuinfo");
    for (std::string line; std::getline(cpuinfo, line);)
      if (line.starts_with("model name") && line.find(": ") != std::string::npos)
        return line.substr(line.find(": ") + 2);
    return std::string("CPU");
  }();
  return name;
}

DeviceInfo describe() {
  DeviceInfo info;
  info.id = "native";
  info.name = cpu_name();
  info.driver = "oneTBB, " + std::string(to_string(instruction_set()));
  info.memory_bytes =
      static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  info.max_buffer_bytes = info.memory_bytes;
  return info;
}

/// The CPU seconds of this thread.
double thread_seconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

class NativeBuffer final : public Buffer {
 public:
  explicit NativeBuffer(std::size_t bytes) : pages_(allocate_pages(bytes)) {
    host_ = pages_.get();
    bytes_ = bytes;
  }
  void* memory() { return host_; }

 private:
  Pages pages_;
};

struct NativeKernel final : Kernel {
  explicit NativeKernel(const KernelSource& source) : source(source) {}
  const KernelSource& source;
};

/// The threads of the host on its memory. Nothing is copied, and every call returns when its work is done.
class NativeDevice final : public Device {
 public:
  const DeviceInfo& info() const override { return info_; }

  std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
    check_allocation(info_, bytes);
    return std::make_unique<NativeBuffer>(bytes);
  }
  void upload(Buffer&, std::size_t) override {}
  void download(Buffer&, std::size_t, std::size_t) override {}
  void clear(Buffer& buffer, std::size_t bytes) override {
    std::memset(static_cast<NativeBuffer&>(buffer).memory(), 0, bytes);
  }

  std::unique_ptr<Kernel> load(const KernelSource& source, Shape, std::uint32_t) override {
    return std::make_unique<NativeKernel>(source);
  }
  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    const KernelSource& source = static_cast<NativeKernel&>(kernel).source;
    check_dispatch(source, buffers.size(), parameters.size(), units);
    std::vector<void*> bound;
    for (Buffer* buffer : buffers) bound.push_back(static_cast<NativeBuffer*>(buffer)->memory());
    std::atomic<double> seconds = 0;
    parallel_ranges(0, units, grain, [&](std::size_t begin, std::size_t end) {
      const double start = thread_seconds();
      source.native(bound.data(), parameters.data(), static_cast<std::uint32_t>(begin),
                    static_cast<std::uint32_t>(end));
      seconds.fetch_add(thread_seconds() - start, std::memory_order_relaxed);
    });
    seconds_ += seconds;
  }
  void wait() override {}
  double kernel_seconds() const override { return seconds_; }

 private:
  DeviceInfo info_ = describe();
  double seconds_ = 0;
};

}  // namespace

std::vector<DeviceInfo> list_native(std::vector<std::string>&) {
  return {describe()};
}

std::unique_ptr<Device> open_native(std::size_t, ZeroCopy) {
  return std::make_unique<NativeDevice>();
}

}  // namespace boxunion

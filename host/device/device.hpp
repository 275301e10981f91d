#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/device.hpp"

namespace boxunion {

/// The three forms of a kernel, embedded at build time (see kernels/dialect.h and cmake/Kernels.cmake).
struct KernelSource {
  std::string_view name;
  std::string_view opencl;                  ///< OpenCL C 1.2 text, including the dialect
  std::string_view opencl_options;          ///< -D macros that select this variant of the source
  std::span<const std::uint32_t> spirv[2];  ///< by Shape; empty if built without a GLSL compiler
  /// Runs work units [begin, end) natively on buffers bound in order.
  void (*native)(void* const* buffers, const void* parameters, std::uint32_t begin, std::uint32_t end);
  std::uint32_t buffers;          ///< number of buffers bound
  std::uint32_t parameter_bytes;  ///< size of the parameter block, at most 128
};

/// Host memory and its mirror on a device. On a unified device, both are the same memory.
class Buffer {
 public:
  virtual ~Buffer() = default;
  std::size_t bytes() const { return bytes_; }
  /// The view of the host, as an array of T.
  template <class T>
  std::span<T> view() {
    return {static_cast<T*>(host_), bytes_ / sizeof(T)};
  }

 protected:
  void* host_ = nullptr;
  std::size_t bytes_ = 0;
};

/// A kernel loaded on a device for one shape and workgroup size.
class Kernel {
 public:
  virtual ~Kernel() = default;
};

/// A device that runs kernels: a queue that executes uploads, dispatches and downloads in the order given.
///
/// Everything but wait() and allocate() may return before the work is done. Between an upload or dispatch
/// that uses a host view and the next wait(), the view must not be touched. Every member throws Error(device)
/// or Error(resources). Not thread-safe: one thread at a time.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;
  virtual std::unique_ptr<Buffer> allocate(std::size_t bytes) = 0;
  /// Copies the first `bytes` of the host's view to the device.
  virtual void upload(Buffer& buffer, std::size_t bytes) = 0;
  /// Copies `bytes` of the device's memory, from `offset` on, to the host's view.
  virtual void download(Buffer& buffer, std::size_t offset, std::size_t bytes) = 0;
  /// Zeroes the first `bytes` on the device.
  virtual void clear(Buffer& buffer, std::size_t bytes) = 0;
  virtual std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) = 0;
  /// Runs `units` work units of a kernel. `parameters` is copied.
  virtual void dispatch(Kernel& kernel, std::span<Buffer* const> buffers,
                        std::span<const std::byte> parameters, std::uint32_t units) = 0;
  virtual void wait() = 0;
  /// The device seconds of all dispatches since the device was opened, as of the last wait(). Natively, the
  /// CPU seconds of all threads.
  virtual double kernel_seconds() const = 0;
};

/// Opens a device: "auto" (the first GPU, otherwise native), "native", "opencl", "opencl:1", "vulkan",
/// "vulkan:0". Throws Error(device) if there is no such device.
///
/// For tests, BOXUNION_FAIL_DEVICE="dispatch:3" (or allocate, upload, download, clear, load, wait) makes
/// every opened device other than native fail at the n-th such call.
std::unique_ptr<Device> open_device(const std::string& id);

}  // namespace boxunion

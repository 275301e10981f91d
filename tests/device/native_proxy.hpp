#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "host/device/device.hpp"

namespace boxunion {

/// Forwards to the native device. Tests override parts of it.
class NativeProxy : public Device {
 public:
  const DeviceInfo& info() const override { return native_->info(); }
  std::unique_ptr<Buffer> allocate(std::size_t bytes) override { return native_->allocate(bytes); }
  void upload(Buffer& buffer, std::size_t bytes) override { native_->upload(buffer, bytes); }
  void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
    native_->download(buffer, offset, bytes);
  }
  void clear(Buffer& buffer, std::size_t bytes) override { native_->clear(buffer, bytes); }
  std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
    return native_->load(source, shape, workgroup);
  }
  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    native_->dispatch(kernel, buffers, parameters, units);
  }
  void wait() override { native_->wait(); }
  double kernel_seconds() const override { return native_->kernel_seconds(); }

 private:
  std::unique_ptr<Device> native_ = open_device("native");
};

}  // namespace boxunion

#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include "boxunion/error.hpp"
#include "host/device/device.hpp"

namespace boxunion {

/// Makes the buffer hold at least `bytes`. Its contents are lost if it must grow.
inline void reserve(Device& device, std::unique_ptr<Buffer>& buffer, std::size_t bytes) {
  if (buffer && buffer->bytes() >= bytes) return;
  buffer.reset();
  const std::size_t limit = device.info().max_buffer_bytes;
  if (bytes > limit) throw Error(ErrorKind::resources, "a batch exceeds the device's largest buffer");
  buffer = device.allocate(std::min(limit, std::max<std::size_t>(bytes + bytes / 4, 4096)));
}

/// Copies an array to the device.
template <class T>
void upload(Device& device, std::unique_ptr<Buffer>& buffer, std::span<const T> values) {
  reserve(device, buffer, values.size_bytes());
  std::ranges::copy(values, buffer->view<T>().begin());
  device.upload(*buffer, values.size_bytes());
}

}  // namespace boxunion

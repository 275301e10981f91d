#include "host/device/failing_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "boxunion/error.hpp"
#include "host/device/forwarding_device.hpp"

namespace boxunion {
namespace {

/// A device that fails at the n-th call of one kind.
class FailingDevice final : public ForwardingDevice {
 public:
  FailingDevice(std::unique_ptr<Device> device, std::string_view call, int n)
      : ForwardingDevice(std::move(device)), call_(call), countdown_(n) {}

 private:
  void before(std::string_view call) override {
    if (call == call_ && --countdown_ == 0)
      throw Error(ErrorKind::device, fmt::format("{}: injected failure of {}", info().id, call));
  }

  std::string call_;
  int countdown_;
};

}  // namespace

std::unique_ptr<Device> failing_if_asked(std::unique_ptr<Device> device) {
  const char* value = std::getenv("BOXUNION_FAIL_DEVICE");
  if (value == nullptr || *value == '\0') return device;
  const std::string_view text(value);
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view call = text.substr(0, colon), number = text.substr(std::min(colon + 1, text.size()));
  int n = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), n);
  if (error != std::errc() || end != number.data() + number.size() || n < 1)
    throw Error(ErrorKind::usage, fmt::format("BOXUNION_FAIL_DEVICE={}: expected a call and a number from 1, "
                                              "for example dispatch:3",
                                              text));
  return std::make_unique<FailingDevice>(std::move(device), call, n);
}

}  // namespace boxunion

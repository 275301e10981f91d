#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "boxunion/error.hpp"
#include "host/bench/device_check.hpp"
#include "host/command/command.hpp"
#include "host/command/command_results.hpp"

namespace boxunion::command {
namespace {

/// "ok", or "FAILED" and a line for each kernel that failed.
std::string text_of(const DeviceCheck& check) {
  const std::string head = fmt::format("{:10}  {}", check.info.id, check.is_ok() ? "ok" : "FAILED");
  if (!check.failure.empty()) return fmt::format("{}: {}\n", head, check.failure);
  std::string text = head + "\n";
  for (const KernelCheck& kernel : check.kernels)
    if (!kernel.failure.empty())
      text += fmt::format("            {}: {}\n", kernel.kernel, kernel.failure);
    else if (kernel.ran_natively)
      text += fmt::format("            {}: right, but in part natively: the device cuts long loops short\n",
                          kernel.kernel);
  return text;
}

std::string json_of(const DeviceCheck& check) {
  std::string kernels;
  for (const KernelCheck& kernel : check.kernels)
    kernels += fmt::format("{}{{\"kernel\": {}, \"ok\": {}, \"failure\": {}, \"ran_natively\": {}}}",
                           kernels.empty() ? "" : ", ", json_string(kernel.kernel), kernel.failure.empty(),
                           json_string(kernel.failure), kernel.ran_natively);
  return fmt::format("{{\"id\": {}, \"ok\": {}, \"failure\": {}, \"kernels\": [{}]}}",
                     json_string(check.info.id), check.is_ok(), json_string(check.failure), kernels);
}

}  // namespace

void check_devices(const Common& common) {
  std::string json, failed;
  boxunion::check_devices(
      [&](const DeviceCheck& check) {
        if (!common.json) print(text_of(check));
        json += (json.empty() ? "" : ", ") + json_of(check);
        if (!check.is_ok()) failed += (failed.empty() ? "" : ", ") + check.info.id;
      },
      tuned_launches());
  if (common.json) print(fmt::format("{{\"devices\": [{}]}}\n", json));
  if (!failed.empty()) throw Error(ErrorKind::device, fmt::format("{} failed the check", failed));
}

}  // namespace boxunion::command

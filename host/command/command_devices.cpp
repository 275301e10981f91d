#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "host/command/command.hpp"
#include "host/command/command_results.hpp"
#include "host/device/device.hpp"
#include "host/tuning/tuning.hpp"

namespace boxunion::command {
namespace {

/// The launches of the kernels on a device, as members of a JSON object. Empty for the native device, which
/// has no choice.
std::string json_launches(const DeviceInfo& device, const Tuning& tuning) {
  std::string json;
  if (device.id == "native") return json;
  for (const std::string_view kernel : benchmark_kernels()) {
    const Launch launch = choose_launch(device, kernel, tuning);
    json += fmt::format("{}{}: {{\"shape\": {}, \"workgroup\": {}, \"tuned\": {}}}", json.empty() ? "" : ", ",
                        json_string(kernel), json_string(to_string(launch.shape)), launch.workgroup,
                        tuning.tuned->find(device, kernel) == launch);
  }
  return json;
}

/// The same as a line of text, if anything was tuned.
std::string text_launches(const DeviceInfo& device, const Tuning& tuning) {
  std::string text;
  if (device.id == "native") return text;
  for (const std::string_view kernel : benchmark_kernels()) {
    const Launch launch = choose_launch(device, kernel, tuning);
    if (tuning.tuned->find(device, kernel) == launch)
      text += fmt::format("{}{} {} {}", text.empty() ? "" : ", ", kernel, to_string(launch.shape),
                          launch.workgroup);
  }
  return text.empty() ? text : fmt::format("{} tuned: {}\n", device.id, text);
}

}  // namespace

void devices(const Common& common) {
  std::vector<std::string> notes;
  const std::vector<DeviceInfo> devices = list_devices(&notes);
  const Tuning tuned{.tuned = tuned_launches()};
  const std::string path = tuning_path();
  std::error_code ignored;
  const std::string tuning_file = std::filesystem::exists(path, ignored) ? path : "";
  std::string out;
  if (common.json) {
    for (const DeviceInfo& d : devices)
      out += fmt::format(
          "{}{{\"id\": {}, \"name\": {}, \"driver\": {}, \"cpu\": {}, \"unified_memory\": {}, "
          "\"memory_bytes\": {}, \"max_buffer_bytes\": {}, \"max_workgroup\": {}, \"launches\": {{{}}}}}",
          out.empty() ? "" : ", ", json_string(d.id), json_string(d.name), json_string(d.driver), d.is_cpu,
          d.is_unified, d.memory_bytes, d.max_buffer_bytes, d.max_workgroup, json_launches(d, tuned));
    std::string note_list;
    for (const std::string& note : notes) note_list += (note_list.empty() ? "" : ", ") + json_string(note);
    print(fmt::format("{{\"devices\": [{}], \"notes\": [{}], \"tuning_file\": {}}}\n", out, note_list,
                      tuning_file.empty() ? "null" : json_string(tuning_file)));
    return;
  }
  std::size_t id_width = 0, name_width = 0;
  for (const DeviceInfo& d : devices) {
    id_width = std::max(id_width, d.id.size());
    name_width = std::max(name_width, d.name.size());
  }
  for (const DeviceInfo& d : devices)
    out += fmt::format("{:{}}  {}  {:6.1f} GiB  {:{}}  {}\n", d.id, id_width, d.is_cpu ? "CPU" : "GPU",
                       double(d.memory_bytes) / double(1 << 30), d.name, name_width, d.driver);
  for (const DeviceInfo& d : devices) out += text_launches(d, tuned);
  if (!tuning_file.empty()) out += fmt::format("tuning file: {}\n", printable(tuning_file));
  for (const std::string& note : notes) out += fmt::format("note: {}\n", note);
  print(out);
}

}  // namespace boxunion::command

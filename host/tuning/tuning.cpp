#include "host/tuning/tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "boxunion/error.hpp"
#include "host/device/backend.hpp"
#include "host/files/input.hpp"

namespace boxunion {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "boxunion tuning 1";
constexpr std::size_t kMostBytes = std::size_t{1} << 20;

/// The launch of an entry; nothing if it is invalid.
std::optional<Launch> parse_launch(const Json& entry) {
  if (!entry.is_object()) return {};
  const auto shape = entry.find("shape"), workgroup = entry.find("workgroup");
  if (shape == entry.end() || workgroup == entry.end() || !workgroup->is_number_unsigned()) return {};
  const auto size = workgroup->get<std::uint64_t>();
  if ((*shape != "group" && *shape != "item") || size < 1 || size > 1024) return {};
  return Launch{*shape == "group" ? Shape::group : Shape::item, std::uint32_t(size)};
}

}  // namespace

std::string_view to_string(Shape shape) {
  return shape == Shape::group ? "group" : "item";
}

void TunedLaunches::set(const DeviceInfo& device, std::string_view kernel, Launch launch) {
  launches_[{device.name, device.driver, std::string(kernel)}] = launch;
}

std::optional<Launch> TunedLaunches::find(const DeviceInfo& device, std::string_view kernel) const {
  const auto found = launches_.find({device.name, device.driver, std::string(kernel)});
  if (found == launches_.end()) return {};
  return found->second;
}

TunedLaunches TunedLaunches::read(const std::string& path,
                                  const std::function<void(const std::string&)>& warn) {
  TunedLaunches result;
  std::error_code error;
  if (path.empty() || !std::filesystem::exists(path, error)) return result;
  const auto ignore = [&](const std::string& what) {
    if (warn) warn(fmt::format("{}: {}; ignored", path, what));
  };
  std::string text;
  try {
    if (!std::filesystem::is_regular_file(path, error)) {
      ignore("not a tuning file: expected a regular file");
      return result;
    }
    text = InputFile(path).read_all(kMostBytes);
  } catch (const Error& failure) {
    if (warn) warn(fmt::format("{}; no tuning", failure.what()));
    return result;
  }
  const Json root = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!root.is_object() || root.value("format", Json()) != kFormat || !root.contains("devices") ||
      !root["devices"].is_array()) {
    ignore(fmt::format("not a tuning file: expected a JSON object with \"format\": \"{}\" and \"devices\"",
                       kFormat));
    return result;
  }
  for (const Json& device : root["devices"]) {
    const bool complete = device.is_object() && device.contains("name") && device["name"].is_string() &&
                          device.contains("driver") && device["driver"].is_string() &&
                          device.contains("kernels") && device["kernels"].is_object();
    if (!complete) {
      ignore("a device without name, driver or kernels");
      continue;
    }
    for (const auto& [kernel, entry] : device["kernels"].items())
      if (const auto launch = parse_launch(entry))
        result.launches_[{device["name"], device["driver"], kernel}] = *launch;
      else
        ignore(fmt::format("kernel {}: expected a shape, group or item, and a workgroup from 1 to 1024",
                           kernel));
  }
  return result;
}

std::shared_ptr<const TunedLaunches> read_tuning(const std::string& path,
                                                 const std::function<void(const std::string&)>& warn) {
  return std::make_shared<const TunedLaunches>(TunedLaunches::read(path, warn));
}

void TunedLaunches::write(OutputFile file) const {
  Json devices = Json::array();
  for (const auto& [key, launch] : launches_) {
    if (devices.empty() || devices.back()["name"] != key.device || devices.back()["driver"] != key.driver)
      devices.push_back({{"name", key.device}, {"driver", key.driver}, {"kernels", Json::object()}});
    devices.back()["kernels"][key.kernel] = {{"shape", to_string(launch.shape)},
                                             {"workgroup", launch.workgroup}};
  }
  file.write(
      Json{{"format", kFormat}, {"devices", devices}}.dump(2, ' ', false, Json::error_handler_t::replace) +
      "\n");
  file.commit();
}

std::string tuning_path() {
  const auto variable = [](const char* name) -> std::string_view {
    const char* value = std::getenv(name);
    return value ? value : "";
  };
  if (std::getenv("BOXUNION_TUNING")) return std::string(variable("BOXUNION_TUNING"));
  constexpr const char* kFile = "boxunion/tuning.json";
  if (const auto config = variable("XDG_CONFIG_HOME"); config.starts_with('/'))  // others are ignored
    return fmt::format("{}/{}", config, kFile);
  if (const auto home = variable("HOME"); !home.empty()) return fmt::format("{}/.config/{}", home, kFile);
  return {};
}

OutputFile open_tuning_file(const std::string& path, OutputGroup* group) {
  std::error_code ignored;  // OutputFile reports problems with the folder
  if (const auto folder = std::filesystem::path(path).parent_path(); !folder.empty())
    std::filesystem::create_directories(folder, ignored);
  return OutputFile(path, group);
}

Launch choose_launch(const DeviceInfo& device, std::string_view kernel, const Tuning& tuning) {
  Launch launch{device.preferred_shape, device.preferred_workgroup};
  if (tuning.tuned)
    if (const auto tuned = tuning.tuned->find(device, kernel);
        tuned && tuned->workgroup <= most_work_items(device, tuned->shape))
      launch = *tuned;
  if (tuning.shape && *tuning.shape != launch.shape)
    launch = {*tuning.shape, std::min(device.preferred_workgroup, most_work_items(device, *tuning.shape))};
  if (tuning.workgroup) launch.workgroup = tuning.workgroup;
  return launch;
}

std::unique_ptr<Kernel> load(Device& device, const KernelSource& source, const Tuning& tuning) {
  const Launch launch = choose_launch(device.info(), source.name, tuning);
  return device.load(source, launch.shape, launch.workgroup);
}

}  // namespace boxunion

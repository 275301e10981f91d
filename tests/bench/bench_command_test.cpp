// `boxunion bench` and the tuning file, as users see them.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "host/device/device.hpp"
#include "tests/command/command.hpp"

namespace boxunion {
namespace {

constexpr const char* kTiny = "bench --quick --size 32 --repetitions 2 ";

class BenchCommand : public Command {
 protected:
  nlohmann::json read_json(const std::string& name) { return nlohmann::json::parse(folder_.read(name)); }
};

TEST_F(BenchCommand, PrintsATableOfEveryKernel) {
  const Outcome r = run(std::string(kTiny) + "--device native");
  EXPECT_EQ(r.status, 0);
  EXPECT_EQ(r.err, "");
  for (const char* text : {"native: ", "empty dispatch", "GB/s", "contour ", "cell_occupancy ",
                           "cell_occupancy_sums ", "cell_boolean ", "cell_boolean_sums ", "cell_faces "})
    EXPECT_NE(r.out.find(text), std::string::npos) << text << "\n" << r.out;
  EXPECT_EQ(r.out.find("skipped"), std::string::npos) << r.out;
  EXPECT_EQ(folder_.file_count(), 0u);
}

TEST_F(BenchCommand, WritesJsonInTheSchemaOfGoogleBenchmark) {
  const Outcome r = run(std::string(kTiny) +
                        "--device native --kernel contour,cell_faces --kernel cell_boolean --json out.json");
  ASSERT_EQ(r.status, 0) << r.err;
  const nlohmann::json root = read_json("out.json");
  const nlohmann::json& context = root.at("context");
  for (const char* key :
       {"date", "host_name", "executable", "num_cpus", "caches", "load_avg", "library_build_type", "devices"})
    EXPECT_TRUE(context.contains(key)) << key;
  ASSERT_EQ(context.at("devices").size(), 1u);
  const nlohmann::json& device = context.at("devices")[0];
  EXPECT_EQ(device.at("id"), "native");
  EXPECT_GT(device.at("copy_bytes_per_second"), 0);
  EXPECT_GT(device.at("dispatch_seconds"), 0);
  std::multiset<std::string> kinds;
  std::set<std::string> names;
  for (const nlohmann::json& entry : root.at("benchmarks")) {
    const std::string type = entry.at("run_type");
    kinds.insert(type == "aggregate" ? std::string(entry.at("aggregate_name")) : type);
    names.insert(entry.at("run_name"));
    for (const char* key : {"name", "family_index", "per_family_instance_index", "repetitions", "threads",
                            "iterations", "real_time", "cpu_time", "time_unit", "device_seconds"})
      EXPECT_TRUE(entry.contains(key)) << key << entry;
    if (type != "iteration") continue;
    EXPECT_EQ(entry.at("name"), entry.at("run_name"));
    for (const char* key : {"cells", "boxes", "vertices", "bytes_read", "bytes_written", "first_run_seconds",
                            "cells_per_second", "boxes_per_second", "vertices_per_second", "bytes_per_second",
                            "copy_bandwidth_fraction"})
      EXPECT_GT(entry.at(key), 0) << key << entry;
  }
  EXPECT_EQ(names,
            (std::set<std::string>{"native/contour/item/1/middle/32", "native/cell_faces/item/1/middle/32",
                                   "native/cell_boolean/item/1/middle/32"}));
  EXPECT_EQ(kinds, (std::multiset<std::string>{"iteration", "iteration", "iteration", "iteration",
                                               "iteration", "iteration", "median", "median", "median",
                                               "stddev", "stddev", "stddev"}));
}

TEST_F(BenchCommand, ComparesTwoFiles) {
  const auto file = [](double a, double b, const char* last) {
    const auto entry = [](const std::string& name, double seconds) {
      return nlohmann::json{{"name", name},
                            {"run_type", "iteration"},
                            {"real_time", 1e9 * seconds},
                            {"time_unit", "ns"},
                            {"device_seconds", seconds}};
    };
    return nlohmann::json{{"context", nlohmann::json::object()},
                          {"benchmarks", {entry("first", a), entry("second", b), entry(last, 1)}}}
        .dump();
  };
  folder_.write("old.json", file(1, 1, "gone"));
  folder_.write("new.json", file(2, 0.5, "come"));
  const Outcome r = run("bench --compare old.json new.json");
  EXPECT_EQ(r.status, 0) << r.err;
  const auto line = [&](const std::string& name) {
    const std::size_t at = r.out.find("\n" + name);
    return at == r.out.npos ? "" : r.out.substr(at + 1, r.out.find('\n', at + 1) - at - 1);
  };
  EXPECT_TRUE(line("first").find("+100.0%") != std::string::npos && line("first").ends_with("slower"))
      << r.out;
  EXPECT_TRUE(line("second").find("-50.0%") != std::string::npos && line("second").ends_with("faster"))
      << r.out;
  EXPECT_TRUE(line("gone").ends_with("only in old.json")) << r.out;
  EXPECT_TRUE(line("come").ends_with("only in new.json")) << r.out;

  EXPECT_NE(run("bench --compare old.json old.json").out.find("same"), std::string::npos);
  expect_error("bench --compare old.json none.json", 3, "none.json: cannot read: No such file or directory");
  folder_.write("text.json", "{}");
  const Outcome wrong = run("bench --compare old.json text.json");
  EXPECT_EQ(wrong.status, 3);
  EXPECT_TRUE(wrong.err.starts_with("boxunion: error: text.json: not results of a benchmark")) << wrong.err;
}

TEST_F(BenchCommand, WrongUsageExitsWith2AndLeavesNoFile) {
  EXPECT_EQ(run("bench --kernel magic").status, 2);
  EXPECT_EQ(run("bench --shape round").status, 2);
  EXPECT_EQ(run("bench --size 0").status, 2);
  EXPECT_EQ(run("bench --repetitions 0").status, 2);
  EXPECT_EQ(run("bench --compare one.json").status, 2);
  EXPECT_EQ(run("bench --device magic --json a.json").status, 4);
  EXPECT_EQ(run("bench --json no/folder/a.json").status, 3);
  expect_error("bench --tune /dev/null/tuning.json", 3,
               "/dev/null/tuning.json: cannot create the file: /dev/null is not a folder");
  EXPECT_EQ(folder_.file_count(), 0u);
}

TEST_F(BenchCommand, SkipsADeviceThatFails) {
  for (const DeviceInfo& device : list_devices()) {
    const std::string& id = device.id;
    if (id == "native") continue;
    const Outcome r = shell("BOXUNION_FAIL_DEVICE=dispatch:1 boxunion " + std::string(kTiny) +
                            "--kernel contour --device native," + id);
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.err.find("warning: " + id + " is skipped: "), std::string::npos) << r.err;
    EXPECT_NE(r.out.find("native: "), std::string::npos);
  }
}

TEST_F(BenchCommand, NativeHasNothingToTune) {
  const Outcome r = run(std::string(kTiny) + "--device native --kernel contour --tune tuning.json");
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_NE(r.out.find("nothing to tune"), std::string::npos);
  EXPECT_EQ(folder_.file_count(), 0u);
}

TEST_F(BenchCommand, TunesADeviceAndUsesWhatItFound) {
  for (const DeviceInfo& device : list_devices()) {
    const std::string& id = device.id;
    if (id == "native") continue;
    SCOPED_TRACE(id);
    const auto launch = [&] {
      const Outcome r = shell("BOXUNION_TUNING=new/tuning.json boxunion devices --json");
      EXPECT_EQ(r.err, "");
      const nlohmann::json root = nlohmann::json::parse(r.out);
      for (const nlohmann::json& entry : root.at("devices"))
        if (entry.at("id") == id) return entry.at("launches").at("contour");
      return nlohmann::json();
    };
    EXPECT_EQ(launch().at("tuned"), false);
    const Outcome r =
        run(std::string(kTiny) + "--kernel contour --workgroup 2,4 --tune new/tuning.json --device " + id);
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.out.find("tuning file: new/tuning.json"), std::string::npos) << r.out;
    EXPECT_EQ(launch().at("tuned"), true);

    // whichever launch was best, the file decides
    nlohmann::json file = read_json("new/tuning.json");
    nlohmann::json& entry = file.at("devices").back().at("kernels").at("contour");
    EXPECT_EQ(entry.at("workgroup"), launch().at("workgroup"));
    entry = {{"shape", "item"}, {"workgroup", 5}};
    folder_.write("new/tuning.json", file.dump());
    EXPECT_EQ(launch(), (nlohmann::json{{"shape", "item"}, {"workgroup", 5}, {"tuned", true}}));
    std::filesystem::remove_all(folder_.file("new"));
  }
}

TEST_F(BenchCommand, ABrokenTuningFileCostsAWarningOnly) {
  folder_.write("boxes.csv", "0,0,0,2,2,2\n1,1,1,3,3,3\n");
  folder_.write("broken.json", "{\"format\": ");
  const std::string measure = "boxunion measure boxes.csv --json --device native";
  const auto without_seconds = [](const std::string& text) {
    nlohmann::json json = nlohmann::json::parse(text);
    json.erase("seconds");
    return json;
  };
  const Outcome clean = shell(measure), broken = shell("BOXUNION_TUNING=broken.json " + measure);
  EXPECT_EQ(clean.err, "");
  EXPECT_EQ(broken.status, 0);
  EXPECT_TRUE(broken.err.starts_with("boxunion: warning: broken.json: not a tuning file")) << broken.err;
  EXPECT_EQ(without_seconds(broken.out), without_seconds(clean.out));
  EXPECT_EQ(shell("BOXUNION_TUNING=none.json " + measure).err, "");
}

}  // namespace
}  // namespace boxunion

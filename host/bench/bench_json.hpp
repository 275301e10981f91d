#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bench/kernel_bench.hpp"
#include "host/files/output.hpp"

namespace boxunion {

/// Writes and commits results in the JSON schema of Google Benchmark, so that its tools read them too.
///
/// Every run of a case is an entry of run_type "iteration". real_time is wall time, cpu_time that of the
/// process, and device_seconds that of the kernel. The counters are rates per second of device time. Median,
/// stddev and cv follow as aggregates. A skipped case has error_occurred and error_message. The context
/// describes the machine, the build, and the devices with their yardsticks.
void write_bench_json(const BenchResults& results, OutputFile file);

/// A case in two files of results. A side is empty if its file lacks the case.
struct BenchChange {
  std::string name;
  std::optional<Spread> before, after;  ///< seconds

  /// after / before - 1. Only if both are there.
  double change() const { return after->median / before->median - 1; }
  double noise() const;
};

/// Compares two files in the schema of Google Benchmark, in the order of the older one. Compares
/// device_seconds if both have them, otherwise real_time. Throws Error(input) if a file cannot be read or has
/// another schema.
std::vector<BenchChange> compare_bench_json(const std::string& before, const std::string& after);

}  // namespace boxunion

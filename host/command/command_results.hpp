#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "boxunion/mass.hpp"
#include "host/command/command.hpp"
#include "host/command/command_output.hpp"

// Shared by the subcommands that compute unions and combinations.

namespace boxunion::command {

/// The options of a run. They keep references to `common` and `bar`.
Options engine_options(const Common& common, ProgressBar& bar);

/// The launches in this user's tuning file. Warns if the file is broken.
std::shared_ptr<const TunedLaunches> tuned_launches();

/// The results from bounds to extreme vertices.
std::vector<Result> mass_results(const MassProperties& mass);

/// Adds method, kernel, device and seconds.
void add_report(std::vector<Result>& results, const Report& report);

/// Adds the slabs, if there were any, and the report, and prints all results.
void finish(std::vector<Result>& results, std::optional<std::uint64_t> slabs, const Report& report,
            const Common& common);

}  // namespace boxunion::command

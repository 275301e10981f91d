#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/solid/mass_sink.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/command/command.hpp"
#include "host/command/command_output.hpp"
#include "host/files/files.hpp"

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

/// Writes a boundary to a file, as vertices or as a mesh. Opens the file at once, before the work that fills
/// it.
class BoundaryWriter {
 public:
  BoundaryWriter(const std::string& output, const BoundaryOptions& options, const Common& common,
                 OutputGroup& outputs);

  /// Writes the file and adds the time to the report.
  void write(const Solid& solid, const Options& options, Report& report);
  /// The results: counts, as far as they are known or asked for, and the file. Warns of rounded coordinates.
  std::vector<Result> results() const;

 private:
  std::string output_;
  const BoundaryOptions& options_;
  const Common& common_;
  OutputFile file_;
  std::vector<Result> results_;
  bool exact_ = true;
};

}  // namespace boxunion::command

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/solid/mass.hpp"
#include "core/solid/solid.hpp"
#include "host/command/command.hpp"
#include "host/command/command_output.hpp"
#include "host/files/files.hpp"

// What the subcommands that find unions and combinations share.

namespace boxunion::command {

/// The options of a run; they refer to `common` and `bar`.
Options engine_options(const Common& common, ProgressBar& bar);

/// What this user's tuning file says, with warnings of what is wrong with it.
std::shared_ptr<const TunedLaunches> tuned_launches();

/// From bounds to extreme vertices.
std::vector<Result> mass_results(const MassProperties& mass);

/// Adds method, kernel, device and seconds.
void add_report(std::vector<Result>& results, const Report& report);

/// Writes boundaries to a file, as vertices or as a mesh. Opens it at once, before the work that fills it.
class BoundaryWriter {
 public:
  BoundaryWriter(const std::string& output, const BoundaryOptions& options, const Common& common,
                 OutputGroup& outputs);

  /// Writes the file; adds to the report what that takes.
  void write(const Solid& solid, const Options& options, Report& report);
  /// What was written: counts, as far as they are known or asked for, and the file. Warns of rounded
  /// coordinates.
  std::vector<Result> results() const;

 private:
  std::string output_;
  const BoundaryOptions& options_;
  const Common& common_;
  OutputFile file_;
  FileFormat format_;
  std::vector<Result> results_;
  bool exact_ = true;
};

}  // namespace boxunion::command

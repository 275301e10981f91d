#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/families.hpp"

namespace boxunion::soak {

/// A run of the command with a signal at some moment, a limit of memory, or both.
struct CommandJob {
  const Family* family = nullptr;  ///< null: a porous volume
  std::size_t size = 0;            ///< approximate number of boxes
  RowOrder order = RowOrder::given;
  std::vector<std::string> inputs;  ///< files that it reads
  std::vector<std::string> arguments;
  std::vector<std::string> outputs;        ///< files that it writes
  bool outputs_exist = false;              ///< true if the outputs exist before the run
  std::optional<std::uint64_t> megabytes;  ///< the budget, if there is one
  int signal = 0;
  double moment = 0;  ///< seconds until the signal
};

struct CommandOptions {
  std::string program;        ///< path of the command
  bool only_signals = false;  ///< run only jobs with a signal
  double latency = 1;         ///< maximum seconds from a signal to the end
  double limit = 300;         ///< maximum seconds of a run
  std::string late;           ///< shell command for a run that is late; its process id is appended
};

CommandJob make_command_job(std::uint64_t seed, const CommandOptions& options);
std::string name(const CommandJob& job);

/// Runs the job in a folder of its own. Returns a description of the fault, or nothing. Faults are: a crash,
/// a wrong exit status, an output that is neither whole nor the old one, a file left over, a budget exceeded,
/// an interrupt that takes too long. Counts the kinds of runs in `done`.
std::string run(const CommandJob& job, const CommandOptions& options, std::map<std::string, int>& done);

}  // namespace boxunion::soak

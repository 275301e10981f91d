#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/families.hpp"

namespace boxunion::soak {

/// A run of the command, with a signal at some moment, a budget of memory, or both.
struct CommandJob {
  const Family* family = nullptr;  ///< none: a porous volume
  std::size_t size = 0;            ///< boxes, about
  RowOrder order = RowOrder::given;
  std::vector<std::string> inputs;  ///< files that it reads
  std::vector<std::string> arguments;
  std::vector<std::string> outputs;        ///< files that it writes
  bool outputs_exist = false;              ///< before the run
  std::optional<std::uint64_t> megabytes;  ///< of the budget
  int signal = 0;
  double moment = 0;  ///< seconds until the signal
};

struct CommandOptions {
  std::string program;        ///< path of the command
  bool only_signals = false;  ///< no job without one
  double latency = 1;         ///< seconds that may pass from a signal to the end
  double limit = 300;         ///< seconds that a run may take
  std::string late;           ///< shell command for one that is late, with the process id behind it
};

CommandJob make_command_job(std::uint64_t seed, const CommandOptions& options);
std::string name(const CommandJob& job);

/// Runs the job in a folder of its own and returns what is wrong, or nothing: a crash, another exit status
/// than it should have, an output that is neither whole nor the old one, a file left over, a budget passed,
/// an interrupt that takes too long. Counts in `done`.
std::string run(const CommandJob& job, const CommandOptions& options, std::map<std::string, int>& done);

}  // namespace boxunion::soak

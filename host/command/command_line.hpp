#pragma once

namespace boxunion::command {

/// Runs the subcommand in the arguments of the program. Throws Error, also for wrong usage and for lack of
/// memory.
void run_command_line(int argc, const char* const* argv);

}  // namespace boxunion::command

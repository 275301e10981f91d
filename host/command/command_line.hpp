#pragma once

namespace boxunion::command {

/// Does what the arguments of the program ask for. Throws Error, also for wrong usage and for lack of memory.
void run_command_line(int argc, const char* const* argv);

}  // namespace boxunion::command

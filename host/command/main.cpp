#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <exception>
#include <string>
#include <string_view>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"
#include "host/command/command_line.hpp"
#include "host/command/command_text.hpp"

namespace {

using namespace boxunion;

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "the signal handler sets it");

/// The first signal asks the work to stop and clean up; one that comes more than a second later kills.
/// (timeout(1) sends its signal twice at once.)
void stop(int signal) {
  static std::atomic<std::time_t> first = 0;
  const std::time_t now = std::time(nullptr);
  if (interrupted && now > first + 1) {
    ::signal(signal, SIG_DFL);
    ::raise(signal);
  }
  if (!interrupted) first = now;
  interrupted = true;
}

/// Handles the signals that ask to stop, except those that were ignored when this process started, as nohup
/// does.
void handle_signals() {
  struct sigaction action = {}, inherited;
  action.sa_sigaction = [](int signal, siginfo_t* info, void*) {
    // Our own write to a closed pipe, or beyond the size limit of files, also fails with an error that says
    // more than the signal.
    const bool is_by_write = (signal == SIGPIPE || signal == SIGXFSZ) && info->si_pid == ::getpid();
    if (!is_by_write) stop(signal);
  };
  action.sa_flags = SA_SIGINFO;
  constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ};
  sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) sigaddset(&action.sa_mask, signal);
  for (const int signal : kSignals)
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler != SIG_IGN)
      sigaction(signal, &action, nullptr);
}

/// Opens standard streams that are closed, so that no file gets their numbers. Reads from them and writes to
/// them still fail.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0)  // this is the lowest free number
      if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream)
        std::_Exit(int(ErrorKind::resources));
}

/// Prints an error on one line and returns the exit status.
int fail(int status, const std::string& message) {
  std::fprintf(stderr, "boxunion: error: %s\n", command::printable(message).c_str());
  return status;
}
int fail(ErrorKind kind, const std::string& message) {
  return fail(int(kind), message);
}

/// Runs the command and returns its exit status.
int run(int argc, const char* const* argv) {
  try {
    command::run_command_line(argc, argv);
    return 0;
  } catch (const Error& error) {
    return fail(error.kind(), error.what());
  } catch (const std::exception& error) {
    if (std::string_view(error.what())
            .starts_with("pthread_create"))  // from oneTBB, if the system refuses threads
      return fail(ErrorKind::resources, error.what());
    return fail(1, fmt::format("internal error: {}", error.what()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  handle_signals();
  const Interruptible scope(&interrupted);
  return run(argc, argv);
}

// Random jobs, each checked.
//
//   boxunion_soak [--jobs N] [--commands N] [--first SEED] [--native] ...
//
// A job makes boxes of many kinds and numbers, and finds their union in a random way (method, kernel, device,
// launch, cell sizes, threads). Some jobs have a device that fails midway, an interrupt, another thread
// beside them, or slabs on disk. Few boxes are compared with brute force, more boxes with the other method,
// natively. A command is a run of the command line with a signal at a random moment or a budget of memory.
//
// The random numbers from seed SEED + i determine job i, so a job that fails can be run again alone. Jobs run
// in processes of their own, so a crash does not end the others. The exit status is 1 if anything is wrong.

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "tests/soak/commands.hpp"
#include "tests/soak/jobs.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/temporary.hpp"

namespace {

using namespace boxunion;
using namespace boxunion::soak;

struct Totals {
  std::map<std::string, int> done;
  int wrong = 0;

  void report(std::uint64_t seed, const std::string& what, const std::string& job) {
    ++wrong;
    fmt::print("seed {}: {}\n  {}\n", seed, what, job);
    std::fflush(stdout);
  }
};

std::vector<std::string> device_names(bool native) {
  if (native) return {"native"};
  std::vector<std::string> names;
  for (const DeviceInfo& device : list_devices()) names.push_back(device.id);
  return names;
}

/// The worker. Runs jobs and writes to `out` which one begins, what is wrong, and at the end what was done.
void work(std::uint64_t first, std::uint64_t end, bool native, std::FILE* out) {
  const std::vector<std::string> devices = device_names(native);
  std::map<std::string, int> done;
  for (std::uint64_t seed = first; seed < end; ++seed) {
    fmt::print(out, "begin {}\n", seed);
    std::fflush(out);
    std::string what;
    try {
      const Job job = make_job(seed, devices);
      fmt::print(out, "job {}\n", name(job));
      std::fflush(out);
      what = run(job, done);
    } catch (const std::exception& error) {
      what = error.what();
    }
    std::ranges::replace(what, '\n', ' ');
    if (!what.empty()) fmt::print(out, "wrong {}\n", what);
  }
  for (const auto& [what, times] : done) fmt::print(out, "done {} {}\n", times, what);
  std::fflush(out);
}

/// Runs jobs in another process. Returns the seed of the first job that was not started.
class Worker {
 public:
  Worker(std::uint64_t first, std::uint64_t end, bool native) : next_(first), end_(end) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("cannot make a pipe");
    std::fflush(nullptr);
    child_ = ::fork();
    if (child_ < 0) throw std::runtime_error("cannot fork");
    if (child_ == 0) {
      ::close(ends[0]);
      ::setenv("TMPDIR", folder_.path().c_str(), 1);
      work(first, end, native, ::fdopen(ends[1], "w"));
      std::fflush(nullptr);
      ::_exit(0);
    }
    ::close(ends[1]);
    in_ = ends[0];
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() { ::close(in_); }

  /// `late` is a shell command for a worker that hangs; its process id is appended.
  std::uint64_t finish(const std::string& late, Totals& totals) {
    bool hangs = false;
    for (std::string line; read_line(line, hangs);) hear(line, totals);
    if (hangs && !late.empty() && std::system(fmt::format("{} {}", late, child_).c_str()) != 0)
      fmt::print("{}: failed\n", late);
    if (hangs) ::kill(child_, SIGKILL);
    int status = 0;
    ::waitpid(child_, &status, 0);
    if (status == 0) {
      if (folder_.file_count() != 0) totals.report(next_, "files are left over", "of the jobs before");
      return end_;
    }
    totals.report(next_ - 1, hangs ? "takes too long" : fmt::format("crashes with status {}", status), job_);
    return next_;
  }

 private:
  void hear(const std::string& line, Totals& totals) {
    const std::string rest = line.substr(line.find(' ') + 1);
    if (line.starts_with("begin ")) {
      next_ = std::stoull(rest) + 1;
      job_.clear();
    } else if (line.starts_with("job ")) {
      job_ = rest;
    } else if (line.starts_with("wrong ")) {
      totals.report(next_ - 1, rest, job_);
    } else if (line.starts_with("done ")) {
      totals.done[rest.substr(rest.find(' ') + 1)] += std::stoi(rest);
    }
  }

  /// False at the end of the worker's output, or if it is silent for too long.
  bool read_line(std::string& line, bool& hangs) {
    const int patience = (sanitized() ? 1800 : 300) * 1000;  // milliseconds
    for (;;) {
      if (const std::size_t length = heard_.find('\n'); length != std::string::npos) {
        line = heard_.substr(0, length);
        heard_.erase(0, length + 1);
        return true;
      }
      pollfd input{.fd = in_, .events = POLLIN, .revents = 0};
      char buffer[4096];
      if (::poll(&input, 1, patience) == 0) return hangs = true, false;
      const ssize_t n = ::read(in_, buffer, sizeof buffer);
      if (n <= 0) return false;
      heard_.append(buffer, std::size_t(n));
    }
  }

  std::uint64_t next_, end_;
  TemporaryFolder folder_;
  pid_t child_ = -1;
  int in_ = -1;
  std::string heard_;
  std::string job_;  // that has begun
};

void run_jobs(std::uint64_t first, std::uint64_t count, bool native, const std::string& late,
              Totals& totals) {
  constexpr std::uint64_t kOfWorker = 500;
  for (std::uint64_t seed = first; seed < first + count;)
    seed = Worker(seed, std::min(seed + kOfWorker, first + count), native).finish(late, totals);
}

void run_commands(std::uint64_t first, std::uint64_t count, const CommandOptions& options, Totals& totals) {
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const CommandJob job = make_command_job(seed, options);
    if (const std::string what = run(job, options, totals.done); !what.empty())
      totals.report(seed, what, name(job));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Random jobs, each checked.");
  std::uint64_t first = 1, jobs = 100, commands = 0;
  bool native = false;
  CommandOptions options;
  options.program =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path() / ".." / "boxunion").string();
  if (sanitized()) options.latency = 20, options.limit = 1800;
  app.add_option("--first", first, "Seed of the first job")->capture_default_str();
  app.add_option("--jobs", jobs, "How many")->capture_default_str();
  app.add_flag("--native", native, "No OpenCL or Vulkan device");
  app.add_option("--commands", commands, "How many runs of the command line")->capture_default_str();
  app.add_flag("--signals", options.only_signals, "No run without a signal");
  app.add_option("--program", options.program, "The command")
      ->check(CLI::ExistingFile)
      ->capture_default_str();
  app.add_option("--latency", options.latency, "Seconds from a signal to the end of a run")
      ->capture_default_str();
  app.add_option("--late", options.late,
                 "Shell command for a run that is later, or a job that hangs, with its process id behind, "
                 "for example \"gdb -batch -ex "
                 "'thread apply all backtrace' -p\"");
  CLI11_PARSE(app, argc, argv);
  options.program = std::filesystem::absolute(options.program);

  const auto begin = std::chrono::steady_clock::now();
  Totals totals;
  run_jobs(first, jobs, native, options.late, totals);
  run_commands(first, commands, options, totals);
  for (const auto& [what, times] : totals.done) fmt::print("{:8} {}\n", times, what);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{} jobs and {} commands from seed {} on, in {:.0f} s: {} wrong\n", jobs, commands, first,
             seconds, totals.wrong);
  return totals.wrong == 0 ? 0 : 1;
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}

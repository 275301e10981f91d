#include "tests/soak/commands.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <thread>

#include "boxunion/generate.hpp"
#include "host/files/files.hpp"
#include "tests/soak/processes.hpp"
#include "tests/soak/random.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion::soak {
namespace {

void add(std::vector<std::string>& arguments, std::initializer_list<std::string> more) {
  arguments.insert(arguments.end(), more);
}

void add_boundary_output(Random& random, CommandJob& job) {
  job.outputs.push_back("out." +
                        random.one_of<std::string>({"csv", "npy", "obj", "ply", "off", "stl", "3mf"}));
  add(job.arguments, {"-o", job.outputs.back()});
  if (random.one_in(3)) add(job.arguments, {"--nonmanifold", "split"});
}

void add_box_output(Random& random, CommandJob& job, const std::string& option, const std::string& name) {
  job.outputs.push_back(name + random.one_of<std::string>({".csv", ".npy"}));
  add(job.arguments, {option, job.outputs.back()});
}

void add_command(Random& random, CommandJob& job) {
  const std::string connectivity = random.one_of<std::string>({"6", "26"});
  switch (random.below(6)) {
    case 0:
      job.arguments = {"measure", job.inputs[0]};
      if (random.one_in(3)) add(job.arguments, {"--statistics"});
      break;
    case 1:
      job.arguments = {"boundary", job.inputs[0]};
      add_boundary_output(random, job);
      break;
    case 2:
      job.arguments = {"decompose", job.inputs[0]};
      add(job.arguments, {"--model", random.one_of<std::string>({"evm", "oudb", "cudb"})});
      add(job.arguments, {"--order", random.one_of<std::string>({"xyz", "yzx", "zxy", "zyx", "best"})});
      if (random.one_in(3)) add(job.arguments, {"--connectivity", connectivity});
      add_box_output(random, job, "-o", "out");
      break;
    case 3:
      job.arguments = {"label", job.inputs[0], "--connectivity", connectivity};
      add_box_output(random, job, "-o", "out");
      if (!job.family) job.outputs = {"out.npy"}, job.arguments.back() = "out.npy";  // labels of voxels
      if (random.one_in(2)) add_box_output(random, job, "--components", "components");
      break;
    case 4:
      job.arguments = {"combine", random.one_of<std::string>({"A and B", "A or B", "A xor B", "A not B"}),
                       "A=" + job.inputs[0], "B=other.npy"};
      job.inputs.push_back("other.npy");
      if (random.one_in(2)) add_boundary_output(random, job);
      if (random.one_in(2)) add_box_output(random, job, "--boxes", "boxes");
      break;
    default:
      job.inputs.clear();
      job.arguments = {"generate", "boxes", "--count", "20000000", "--max-edge", "100"};
      add_box_output(random, job, "-o", "out");
  }
}

/// Writes the boxes in a process of its own, so that this process stays small: the memory of a process that
/// starts another one counts in the peak of that one.
void write_inputs(const CommandJob& job, const TemporaryFolder& folder) {
  if (job.inputs.empty()) return;
  run_in_child([&] {
    if (!job.family) {
      const auto edge = std::int64_t(std::cbrt(20.0 * double(job.size)));
      const Volume volume = generate_porous({edge, edge, edge}, {.pores = 0.6, .feature = 3}, job.size);
      write_volume<std::uint8_t>(volume.grid, volume.inside, open_output(folder.file(job.inputs[0])));
    }
    const Family& family = job.family ? *job.family : families()[0];
    const BoxSet boxes = reorder(family.make(job.size), job.order);
    if (job.family) write_boxes(boxes, open_output(folder.file(job.inputs[0])));
    if (job.inputs.size() == 1) return;
    std::vector<Box> moved;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      moved.push_back(boxes[i]);
      for (const std::size_t axis : {0, 3}) moved.back()[axis] += 5;
    }
    write_boxes(moved, open_output(folder.file(job.inputs[1])));
  });
}

/// The end of a run of the command.
struct End {
  int status = 0;      ///< the status of waitpid
  double seconds = 0;  ///< from the start, or from the signal if one was sent
  bool signalled = false;
  std::uint64_t peak_bytes = 0;
  std::string out, err;
};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Starts the command in the folder of the job, with its output in files.
pid_t start(const CommandJob& job, const CommandOptions& options, const TemporaryFolder& folder) {
  std::vector<std::string> words = {options.program};
  words.insert(words.end(), job.arguments.begin(), job.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child > 0) return child;
  const auto open = [&](const char* file, int descriptor) {
    ::dup2(::open(folder.file(file).c_str(), O_WRONLY), descriptor);
  };
  open(".out", STDOUT_FILENO);
  open(".err", STDERR_FILENO);
  ::setenv("TMPDIR", folder.file("scratch").c_str(), 1);
  ::setenv("BOXUNION_TUNING", "", 1);
  const rlimit memory{.rlim_cur = rlim_t{8} << 30, .rlim_max = rlim_t{8} << 30};
  if (!sanitized()) ::setrlimit(RLIMIT_AS, &memory);
  if (::chdir(folder.path().c_str()) == 0) ::execv(argv[0], argv.data());
  ::_exit(127);
}

End wait_for(pid_t child, const CommandJob& job, const CommandOptions& options) {
  End end;
  auto begin = Clock::now();
  bool asked = false;  // `late` has been run
  for (;;) {
    rusage usage;
    if (::wait4(child, &end.status, WNOHANG, &usage) == child) {
      end.seconds = seconds_since(begin);
      end.peak_bytes = std::uint64_t(usage.ru_maxrss) * 1024;
      return end;
    }
    const double seconds = seconds_since(begin);
    if (job.signal && !end.signalled && seconds >= job.moment) {
      ::kill(child, job.signal);
      end.signalled = true;
      begin = Clock::now();
    } else if (end.signalled && seconds > options.latency && !asked && !options.late.empty()) {
      asked = true;
      if (std::system(fmt::format("{} {}", options.late, child).c_str()) != 0)
        fmt::print("{}: failed\n", options.late);
    } else if (seconds > options.limit) {
      ::kill(child, SIGKILL);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

std::string check_status(const CommandJob& job, const CommandOptions& options, const End& end) {
  if (WIFSIGNALED(end.status)) {
    constexpr double kStart = 0.2;  // seconds before the signal handler is certainly installed
    const int signal = WTERMSIG(end.status);
    if (signal == job.signal && end.signalled && job.moment < kStart) return {};
    return signal == SIGKILL ? "it had to be killed" : fmt::format("ended by signal {}", signal);
  }
  const int status = WEXITSTATUS(end.status);
  if (status == 130 && end.signalled) {
    if (end.err != "boxunion: error: interrupted\n")
      return "it did not say that it was interrupted: " + end.err;
    if (!end.out.empty()) return "it was interrupted after it had printed results";
  } else if (status != 0 &&
             !(status == 5 && (job.megabytes || end.err.find("memory") != std::string::npos))) {
    return fmt::format("exit status {}: {}", status, end.err);
  }
  if (end.signalled && end.seconds > options.latency)
    return fmt::format("{:.2f} s from the signal to the end", end.seconds);
  return {};
}

std::string check_files(const CommandJob& job, const End& end, const TemporaryFolder& folder) {
  const bool done = WIFEXITED(end.status) && WEXITSTATUS(end.status) == 0;
  std::set<std::string> expected = {"scratch", ".out", ".err"};
  expected.insert(job.inputs.begin(), job.inputs.end());
  for (const std::string& output : job.outputs) {
    if (done || job.outputs_exist) expected.insert(output);
    const bool exists = std::filesystem::exists(folder.file(output));
    if (exists && (folder.read(output) == "old") == done)
      return output + (done ? " is the old one" : " is not the old one");
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    if (expected.erase(entry.path().filename()) == 0) return "left over: " + entry.path().filename().string();
  if (!expected.empty()) return "there is no " + *expected.begin();
  if (!std::filesystem::is_empty(folder.file("scratch"))) return "a scratch file is left over";
  return {};
}

}  // namespace

CommandJob make_command_job(std::uint64_t seed, const CommandOptions& options) {
  Random random(seed);
  CommandJob job;
  if (!random.one_in(8)) job.family = &families()[std::size_t(random.below(int(families().size())))];
  job.inputs = {job.family && random.one_in(4) ? "in.csv" : "in.npy"};
  job.order = kRowOrders[random.below(3)];
  add_command(random, job);
  job.outputs_exist = random.one_in(2);
  if (options.only_signals || random.one_in(2)) {
    job.signal = random.one_of<int>({SIGINT, SIGINT, SIGTERM, SIGTERM, SIGHUP});
    job.moment = random.between(0.01, 2);
  }
  if (job.arguments[0] != "generate" && (!job.signal || random.one_in(3)))
    job.megabytes = std::uint64_t(random.between(100, 1000));
  if (job.megabytes) add(job.arguments, {"--memory", fmt::format("{}M", *job.megabytes)});
  job.size = std::size_t(job.signal ? random.between(20'000, 400'000) : random.between(100, 200'000));
  if (job.arguments[0] != "combine" && job.arguments[0] != "generate" && job.arguments[0] != "label" &&
      job.signal && random.one_in(5))
    add(job.arguments, {"--method", "slices"});
  if (job.arguments[0] != "generate") add(job.arguments, {"--device", "native"});
  return job;
}

std::string name(const CommandJob& job) {
  return fmt::format("boxunion {}; {} {} {}{}", fmt::join(job.arguments, " "),
                     job.family ? job.family->name : "porous volume", job.size, name(job.order),
                     job.signal ? fmt::format("; signal {} after {:.3f} s", job.signal, job.moment) : "");
}

std::string run(const CommandJob& job, const CommandOptions& options, std::map<std::string, int>& done) {
  const TemporaryFolder folder;
  write_inputs(job, folder);
  std::filesystem::create_directory(folder.file("scratch"));
  for (const char* const file : {".out", ".err"})
    folder.write(file, "");  // a signal may come before the command writes
  if (job.outputs_exist)
    for (const std::string& output : job.outputs) folder.write(output, "old");
  End end = wait_for(start(job, options, folder), job, options);
  end.out = folder.read(".out");
  end.err = folder.read(".err");
  ++done[WIFSIGNALED(end.status) ? std::string("commands ended by their signal")
                                 : fmt::format("commands with exit status {}", WEXITSTATUS(end.status))];
  std::string wrong = check_status(job, options, end);
  if (wrong.empty()) wrong = check_files(job, end, folder);
  if (wrong.empty() && job.megabytes && !sanitized() && end.peak_bytes > *job.megabytes << 20)
    wrong = fmt::format("a peak of {:.1f} MiB", double(end.peak_bytes) / (1 << 20));
  return wrong;
}

}  // namespace boxunion::soak

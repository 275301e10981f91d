#pragma once

#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/wait.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/sanitized.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {

struct Outcome {
  int status = -1;
  std::string out, err;
};

/// The folder of the tests, which also holds the command.
inline std::string program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

/// Seconds after which a run of some million boxes has begun but not ended.
inline std::vector<std::string> interrupt_times() {
  if (sanitized()) return {"0.7", "1.4"};  // sanitized commands start slowly
  return {"0.1", "0.2"};
}

/// Runs the built command like a user without a tuning file.
class Command : public testing::Test {
 protected:
  /// Runs `boxunion ARGUMENTS` in the folder of the test. The shell parses the arguments.
  Outcome run(const std::string& arguments) { return shell("boxunion " + arguments); }

  Outcome shell(const std::string& line) {
    Outcome run;
    const std::string environment = "export BOXUNION_TUNING= PATH='" + program_folder() + "':\"$PATH\"";
    FILE* pipe = ::popen(
        ("cd " + folder_.path() + " && " + environment + " && { " + line + "; } 2>.stderr").c_str(), "r");
    char buffer[4096];
    for (std::size_t n; (n = ::fread(buffer, 1, sizeof buffer, pipe)) > 0;) run.out.append(buffer, n);
    const int status = ::pclose(pipe);
    run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    run.err = folder_.read(".stderr");
    std::filesystem::remove(folder_.file(".stderr"));
    return run;
  }

  /// Expects that a run fails with one line on stderr and nothing on stdout.
  void expect_error(const std::string& arguments, int status, const std::string& message) {
    const Outcome r = run(arguments);
    EXPECT_EQ(r.status, status) << arguments;
    EXPECT_EQ(r.out, "") << arguments;
    EXPECT_EQ(r.err, "boxunion: error: " + message + "\n") << arguments;
  }

  nlohmann::json json(const std::string& arguments) {
    const Outcome r = run(arguments);
    EXPECT_EQ(r.status, 0) << arguments << r.err;
    EXPECT_EQ(r.err, "") << arguments;
    return nlohmann::json::parse(r.out);
  }

  TemporaryFolder folder_;
};

}  // namespace boxunion

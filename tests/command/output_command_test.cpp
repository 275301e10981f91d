// The files that a run leaves: output files, whole or not at all, however the run ends and whatever its
// streams are.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/command/command.hpp"

namespace boxunion {
namespace {

using namespace std::string_literals;

class OutputCommand : public Command {
 protected:
  OutputCommand() {
    folder_.write("a.csv", "0,0,0,1,1,1\n3,0,0,4,1,1\n");
    folder_.write("b.csv", "0,0,0,1,1,9\n");
  }

  /// Every way to write files: the arguments without the options that name files beginning with "out".
  const std::vector<std::string> writers_ = {
      "generate cubes --count 3 --edge 2 -o out.csv",
      "generate porous --size 4 --volume -o out.npy",
      "generate phantom --size 4 -o out.npy",
      "boundary a.csv -o out.csv",
      "boundary a.csv -o out.3mf",
      "boundary a.csv -o out.npy --memory 1G",
      "decompose a.csv -o out.csv --model evm",
      "decompose a.csv -o out.npy --memory 1G",
      "label a.csv -o out.csv --components out.npy",
      "combine 'A not B' A=a.csv B=b.csv -o out.ply --boxes out.csv",
      "bench --quick --size 32 --repetitions 2 --device native --kernel contour --json out.json",
  };

  std::vector<std::string> outputs() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      if (const std::string name = entry.path().filename(); name.starts_with("out")) names.push_back(name);
    return names;
  }

  ::mode_t mode(const std::string& name) {
    struct stat status;
    return ::stat(folder_.file(name).c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
  }

  /// True if the tests run with the rights of root.
  static bool is_root() { return ::geteuid() == 0; }
};

TEST_F(OutputCommand, ResultsThatCannotBePrintedReplaceNoFile) {
  for (const std::string& arguments : writers_)
    for (const auto& [stream, reason] :
         {std::pair{" >/dev/full", "No space left on device"}, {" >&-", "Bad file descriptor"}}) {
      SCOPED_TRACE(arguments + stream);
      expect_error(arguments + stream, 5, "standard output: cannot write: "s + reason);
      EXPECT_EQ(outputs(), std::vector<std::string>{});
      for (const char* name : {"out.csv", "out.npy", "out.3mf", "out.ply", "out.json"})
        folder_.write(name, "old");
      expect_error(arguments + stream, 5, "standard output: cannot write: "s + reason);
      for (const std::string& name : outputs()) {
        EXPECT_EQ(folder_.read(name), "old") << name;
        std::filesystem::remove(folder_.file(name));
      }
    }
  for (const std::string arguments : {"--help", "--version", "measure --help", "measure a.csv", "devices"}) {
    expect_error(arguments + " >/dev/full", 5, "standard output: cannot write: No space left on device");
    expect_error(arguments + " >&-", 5, "standard output: cannot write: Bad file descriptor");
  }
}

TEST_F(OutputCommand, AClosedPipeIsAnErrorOfWriting) {
  folder_.write("out.csv", "old");
  const Outcome r = shell("{ sleep 0.3; boxunion boundary a.csv -o out.csv; echo $? >status; } | true");
  EXPECT_EQ(folder_.read("status"), "5\n");
  EXPECT_EQ(r.err, "boxunion: error: standard output: cannot write: Broken pipe\n");
  EXPECT_EQ(folder_.read("out.csv"), "old");
}

TEST_F(OutputCommand, NoFileTakesThePlaceOfAClosedStream) {
  // a set that the expression does not name causes a warning
  const std::string combine = "combine A A=a.csv B=b.csv -o ";
  EXPECT_EQ(run(combine + "open.csv").err,
            "boxunion: warning: B is given, but the expression does not name it\n");
  EXPECT_EQ(run(combine + "out.csv 2>&-").status, 0);
  EXPECT_EQ(folder_.read("out.csv"), folder_.read("open.csv"));
  EXPECT_EQ(run(combine + "out.npy <&- 2>&-").status, 0);
  EXPECT_EQ(run(combine + "open.npy").status, 0);
  EXPECT_EQ(folder_.read("out.npy"), folder_.read("open.npy"));
  std::filesystem::remove(folder_.file("out.csv"));
  EXPECT_EQ(run(combine + "out.csv <&- >&- 2>&-").status, 5);
  EXPECT_EQ(outputs(), std::vector<std::string>{"out.npy"});
  expect_error("measure - <&-", 3, "standard input: cannot read: Bad file descriptor");
}

TEST_F(OutputCommand, KillLeavesNothing) {
  if (!folder_.has_nameless_files()) GTEST_SKIP() << "a file system without nameless files";
  // until it has written a megabyte
  const Outcome r = shell(
      "boxunion generate sponge --level 14 -o out.csv & pid=$!; "
      "for i in $(seq 200); do sleep 0.05; "
      "test \"$(stat -Lc %s /proc/$pid/fd/* | sort -n | tail -n 1)\" -lt 1000000 || break; done; "
      "ls; kill -KILL $pid; wait $pid; echo $?; ls");
  EXPECT_EQ(r.out, "a.csv\nb.csv\n137\na.csv\nb.csv\n") << r.err;
}

TEST_F(OutputCommand, EverySignalThatEndsARunLeavesNothing) {
  for (const std::string signal : {"INT", "TERM", "HUP", "PIPE", "XFSZ"}) {
    SCOPED_TRACE(signal);
    const Outcome r = shell("env --default-signal timeout --foreground --preserve-status -k 30 -s " + signal +
                            " 1 boxunion generate sponge --level 14 -o out.csv");
    EXPECT_EQ(r.status, 130);
    EXPECT_EQ(r.out, "");
    EXPECT_EQ(r.err, "boxunion: error: interrupted\n");
    EXPECT_EQ(outputs(), std::vector<std::string>{});
  }
  const Outcome full =
      shell("ulimit -f 8; exec env --default-signal boxunion generate sponge --level 4 -o out.npy");
  EXPECT_EQ(full.status, 5);
  EXPECT_EQ(full.err, "boxunion: error: out.npy: cannot write: File too large\n");
  EXPECT_EQ(outputs(), std::vector<std::string>{});
}

TEST_F(OutputCommand, SignalsThatWereIgnoredStayIgnored) {
  const auto measure_while = [&](const std::string& line) {
    return shell("{ sleep 2; cat a.csv 2>/dev/null; } | { " + line +
                 "; echo $? >&3; } 3>status & sleep 1; "
                 "kill -HUP $(cat pid); kill -INT $(cat pid) 2>/dev/null; wait");
  };
  const std::string measure = "sh -c 'echo $$ >pid; exec boxunion measure - --json'";
  const Outcome kept = measure_while("trap '' HUP INT; " + measure);
  EXPECT_EQ(folder_.read("status"), "0\n");
  EXPECT_EQ(nlohmann::json::parse(kept.out).at("volume"), 2) << kept.err;
  const Outcome stopped = measure_while("env --default-signal " + measure);
  EXPECT_EQ(folder_.read("status"), "130\n");
  EXPECT_EQ(stopped.out, "");
  EXPECT_EQ(stopped.err, "boxunion: error: interrupted\n");
}

TEST_F(OutputCommand, AnInterruptEndsARunThatWaitsForAReader) {
  nlohmann::json entries = nlohmann::json::array();  // names that fill more than a pipe
  for (int i = 0; i < 10'000; ++i)
    entries.push_back({{"name", "name of a case " + std::to_string(i)}, {"real_time", 1}});
  folder_.write("many.json", nlohmann::json{{"benchmarks", entries}}.dump());
  const Outcome r = shell(
      "{ sh -c 'echo $$ >pid; exec env --default-signal boxunion bench --compare many.json many.json'; "
      "echo $? >status; } | { sleep 1; kill -INT $(cat pid); sleep 1; }");
  EXPECT_EQ(folder_.read("status"), "130\n");
  EXPECT_EQ(r.err, "boxunion: error: interrupted\n");
}

TEST_F(OutputCommand, PermissionsAreThoseOfTheFileThatIsReplaced) {
  for (const std::string umask : {"077", "022", "002"})
    for (const std::string permissions : {"600", "640", "664", "666", "755", "400"}) {
      if (permissions == "400" && !is_root()) continue;  // only root may replace it
      SCOPED_TRACE(umask + " " + permissions);
      const Outcome r =
          shell("umask " + umask + "; echo old >out.csv; chmod " + permissions +
                " out.csv; boxunion decompose a.csv -o out.csv; stat -c %a out.csv; rm -f out.csv");
      EXPECT_TRUE(r.out.ends_with("\n" + permissions + "\n")) << r.out;
    }
  shell("umask 027; boxunion decompose a.csv -o out.csv");
  EXPECT_EQ(mode("out.csv"), 0640u);
}

TEST_F(OutputCommand, OwnersAreThoseOfTheFileThatIsReplaced) {
  if (!is_root()) GTEST_SKIP() << "only root makes files of others";
  folder_.write("out.csv", "old");
  ASSERT_EQ(::chown(folder_.file("out.csv").c_str(), 1234, 4321), 0);
  ASSERT_EQ(::chmod(folder_.file("out.csv").c_str(), 0660), 0);
  EXPECT_EQ(run("decompose a.csv -o out.csv").status, 0);
  EXPECT_EQ(shell("stat -c '%u %g %a' out.csv").out, "1234 4321 660\n");

  // a user who may not keep the group gives it no more than everybody has
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0777), 0);
  ASSERT_EQ(::chmod(folder_.file("out.csv").c_str(), 0666), 0);
  const std::string nobody = "setpriv --reuid 65534 --regid 65534 --clear-groups ";
  if (shell(nobody + "boxunion --version").status != 0) GTEST_SKIP() << "others cannot run the command";
  ASSERT_EQ(::chmod(folder_.file("out.csv").c_str(), 0674), 0);
  ASSERT_EQ(::chown(folder_.file("out.csv").c_str(), 65534, 4321), 0);
  EXPECT_EQ(shell(nobody + "boxunion decompose a.csv -o out.csv --quiet").status, 0);
  EXPECT_EQ(shell("stat -c '%u %g %a' out.csv").out, "65534 65534 644\n");

  // in a folder like /tmp, nobody may replace files of others; the command says so at once
  ASSERT_EQ(::chmod(folder_.path().c_str(), 01777), 0);
  ASSERT_EQ(::chmod(folder_.file("b.csv").c_str(), 0666), 0);
  const Outcome r = shell(nobody + "boxunion decompose none.csv -o b.csv");
  EXPECT_EQ(r.status, 3);
  EXPECT_TRUE(r.err.starts_with("boxunion: error: b.csv: cannot create the file: it belongs to another user"))
      << r.err;
}

TEST_F(OutputCommand, LinksAreFollowed) {
  std::filesystem::create_directory(folder_.file("there"));
  std::filesystem::create_symlink("there/next.csv", folder_.file("link.csv"));
  std::filesystem::create_symlink(folder_.file("there/real.csv"), folder_.file("there/next.csv"));
  EXPECT_EQ(run("decompose a.csv -o direct.csv").status, 0);
  for (const char* state : {"dangling", "not dangling"}) {
    EXPECT_EQ(run("decompose a.csv -o link.csv").status, 0) << state;
    EXPECT_TRUE(std::filesystem::is_symlink(folder_.file("link.csv"))) << state;
    EXPECT_TRUE(std::filesystem::is_symlink(folder_.file("there/next.csv"))) << state;
    EXPECT_EQ(folder_.read("there/real.csv"), folder_.read("direct.csv")) << state;
    folder_.write("there/real.csv", "old");
  }
  std::filesystem::create_symlink("gone/out.csv", folder_.file("nowhere.csv"));
  expect_error("decompose a.csv -o nowhere.csv", 3,
               "nowhere.csv: cannot create the file: gone does not exist");
  std::filesystem::create_symlink("loop.csv", folder_.file("loop.csv"));
  expect_error("decompose a.csv -o loop.csv", 3,
               "loop.csv: cannot create the file: Too many levels of symbolic links");
}

TEST_F(OutputCommand, NamesMayBeAsLongAsTheSystemAllows) {
  const std::string longest = std::string(251, 'n') + ".csv";
  for (const char* state : {"new", "replaced"}) {
    EXPECT_EQ(run("decompose a.csv -o " + longest).status, 0) << state;
    EXPECT_EQ(folder_.read(longest).find("xmin"), 0u) << state;
    folder_.write(longest, "old");
  }
  expect_error("decompose none.csv -o n" + longest, 3,
               "n" + longest + ": cannot create the file: File name too long");
}

TEST_F(OutputCommand, TwoOutputsAreTwoFiles) {
  folder_.write("real.csv", "old");
  std::filesystem::create_symlink("real.csv", folder_.file("link.csv"));
  std::filesystem::create_symlink("new.csv", folder_.file("dangling.csv"));
  std::filesystem::create_hard_link(folder_.file("real.csv"), folder_.file("hard.csv"));
  std::filesystem::create_directory(folder_.file("there"));
  const std::vector<std::pair<std::string, std::string>> same = {
      {"new.csv", "new.csv"},          {"new.csv", "./new.csv"},
      {"new.csv", "there/../new.csv"}, {"new.csv", "dangling.csv"},
      {"dangling.csv", "new.csv"},     {"real.csv", "link.csv"},
      {"real.csv", "hard.csv"},        {"new.csv", folder_.file("new.csv")},
  };
  for (const auto& [a, b] : same) {
    const std::string message = a + " and " + b + " are the same file, expected one for each output";
    expect_error("label none.csv -o " + a + " --components " + b, 2, message);
    expect_error("combine A A=none.csv -o " + a + " --boxes " + b, 2, message);
    expect_error("bench --tune " + a + " --json " + b, 2, message);
  }
  EXPECT_EQ(folder_.read("real.csv"), "old");
  EXPECT_FALSE(std::filesystem::exists(folder_.file("new.csv")));
  EXPECT_EQ(run("label a.csv -o new.csv --components there/new.csv").status, 0);
}

TEST_F(OutputCommand, AnOutputMayBeTheInput) {
  run("generate porous --size 20 -o v.npy --volume");
  for (const std::string memory : {"", " --memory 1G"}) {
    folder_.write("copy.csv", folder_.read("a.csv"));
    folder_.write("copy.npy", folder_.read("v.npy"));
    EXPECT_EQ(run("decompose a.csv -o expected.csv" + memory).status, 0);
    EXPECT_EQ(run("decompose v.npy -o expected.npy" + memory).status, 0);
    EXPECT_EQ(run("decompose copy.csv -o copy.csv" + memory).status, 0);
    EXPECT_EQ(run("decompose copy.npy -o copy.npy" + memory).status, 0);
    EXPECT_EQ(folder_.read("copy.csv"), folder_.read("expected.csv"));
    EXPECT_EQ(folder_.read("copy.npy"), folder_.read("expected.npy"));
  }
}

}  // namespace
}  // namespace boxunion

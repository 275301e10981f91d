// Output files on file systems with and without nameless files and access control lists. files_test.cpp has
// the rest.

#include "host/files/output.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "boxunion/error.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

void write_file(const std::string& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

/// From now on, this process sees no file system with nameless files. Returns false if that fails.
bool forbid_nameless_files() {
  constexpr std::uint32_t kNameless = O_TMPFILE & ~O_DIRECTORY;
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_openat, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[2])),
      BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, kNameless, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EOPNOTSUPP),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  sock_fprog program{.len = std::size(filter), .filter = filter};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

constexpr int kNotForbidden = 77;

/// Runs `f` in its own process, without nameless files. Returns the status of waitpid.
int run_without_nameless_files(const std::function<void()>& f) {
  const ::pid_t child = ::fork();
  if (child == 0) {
    if (!forbid_nameless_files()) ::_exit(kNotForbidden);
    try {
      f();
    } catch (const std::exception&) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return status;
}

::mode_t mode_of(const std::string& path) {
  struct stat status;
  return ::stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

class NamedOutput : public testing::Test {
 protected:
  void SetUp() override {
    const int status = run_without_nameless_files([] {});
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotForbidden)
      GTEST_SKIP() << "no filter of system calls";
  }
  const TemporaryFolder folder_;
};

TEST_F(NamedOutput, IsWholeOrNotThere) {
  std::string name(251, 'n');
  name.append(".csv");
  const std::string path = folder_.file(name);
  const auto run = [&](const std::function<void()>& f) { return run_without_nameless_files(f); };
  EXPECT_EQ(run([&] { write_file(path, "first"); }), 0);
  EXPECT_EQ(folder_.read(name), "first");
  ASSERT_EQ(::chmod(path.c_str(), 0600), 0);
  EXPECT_EQ(run([&] { write_file(path, std::string(3 << 20, 'x')); }), 0);
  EXPECT_EQ(folder_.read(name), std::string(3 << 20, 'x'));
  EXPECT_EQ(mode_of(path), 0600u);
  EXPECT_EQ(run([&] {
              OutputFile file(path);
              file.write("never");
            }),
            0);
  EXPECT_EQ(folder_.read(name).size(), std::size_t{3} << 20);
  EXPECT_EQ(folder_.file_count(), 1u);
}

TEST_F(NamedOutput, IsNoMoreReadableThanTheOldFile) {
  folder_.write("a.csv", "old");
  ASSERT_EQ(::chmod(folder_.file("a.csv").c_str(), 0640), 0);
  const int status = run_without_nameless_files([&] {
    OutputFile file(folder_.file("a.csv"));
    ::raise(SIGKILL);
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(folder_.file_count(), 2u);  // left over here, unlike on systems with nameless files
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    if (entry.path().filename() != "a.csv") {
      EXPECT_TRUE(entry.path().filename().string().ends_with(".partial"));
      EXPECT_EQ(mode_of(entry.path()) & ~0640u, 0u);
    }
}

TEST(OutputFile, AKilledProcessLeavesNothing) {
  const TemporaryFolder folder;
  if (!folder.has_nameless_files()) GTEST_SKIP() << "a file system without nameless files";
  folder.write("a.csv", "old");
  const ::pid_t child = ::fork();
  if (child == 0) {
    OutputFile old(folder.file("a.csv")), fresh(folder.file("b.csv"));
    old.write(std::string(3 << 20, 'x'));
    fresh.write(std::string(3 << 20, 'x'));
    ::raise(SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(folder.read("a.csv"), "old");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(OutputFile, KeepsTheAccessControlListOfTheFileThatItReplaces) {
  const TemporaryFolder folder;
  // version 2; owner rw-, user 1234 r--, group ---, mask rw-, others ---
  const std::string list = bytes<std::uint32_t>({2}) + bytes<std::uint16_t>({1, 6}) + "\xff\xff\xff\xff" +
                           bytes<std::uint16_t>({2, 4}) + bytes<std::uint32_t>({1234}) +
                           bytes<std::uint16_t>({4, 0}) + "\xff\xff\xff\xff" + bytes<std::uint16_t>({16, 6}) +
                           "\xff\xff\xff\xff" + bytes<std::uint16_t>({32, 0}) + "\xff\xff\xff\xff";
  const std::string path = folder.write("a.csv", "old");
  const auto list_of = [](const std::string& file, const char* name) {
    std::string found(1 << 16, '\0');
    const ::ssize_t size = ::getxattr(file.c_str(), name, found.data(), found.size());
    found.resize(std::size_t(std::max<::ssize_t>(size, 0)));
    return found;
  };
  constexpr const char* kAccess = "system.posix_acl_access";
  if (::setxattr(path.c_str(), kAccess, list.data(), list.size(), 0) != 0)
    GTEST_SKIP() << "a file system without access control lists";
  EXPECT_EQ(mode_of(path), 0660u);  // the mask stands for the group
  write_file(path, "new");
  EXPECT_EQ(folder.read("a.csv"), "new");
  EXPECT_EQ(list_of(path, kAccess), list);
  EXPECT_EQ(mode_of(path), 0660u);

  // a folder whose new files get that list does not give it to a file that replaces one without
  ASSERT_EQ(::removexattr(path.c_str(), kAccess), 0);
  ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
  ASSERT_EQ(::setxattr(folder.path().c_str(), "system.posix_acl_default", list.data(), list.size(), 0), 0);
  write_file(path, "newer");
  EXPECT_EQ(list_of(path, kAccess), "");
  EXPECT_EQ(mode_of(path), 0640u);
  write_file(folder.file("b.csv"), "fresh");
  EXPECT_NE(list_of(folder.file("b.csv"), kAccess), "");
}

TEST(OutputGroup, FilesAppearTogether) {
  const TemporaryFolder folder;
  {
    OutputGroup group;
    OutputFile a(folder.file("a.csv"), &group), b(folder.file("b.csv"), &group);
    a.write("a");
    b.write("b");
    a.commit();
    EXPECT_EQ(folder.file_count(), 0u);
    EXPECT_THROW(OutputFile(folder.file("b.csv"), &group), Error);
    group.publish();
    EXPECT_EQ(folder.read("a.csv"), "a");
    EXPECT_EQ(folder.file_count(), 1u);
    b.commit();
  }
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(OutputFile, LandsInTheFolderThatWasOpened) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("b.csv", folder.file("a.csv"));
  OutputFile file(folder.file("a.csv"));
  file.write("text");
  std::filesystem::rename(folder.path(), folder.path() + ".moved");
  file.commit();  // into the folder in which it was opened, whatever its name is now
  std::filesystem::rename(folder.path() + ".moved", folder.path());
  EXPECT_EQ(folder.read("b.csv"), "text");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("a.csv")));
}

}  // namespace
}  // namespace boxunion

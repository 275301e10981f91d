// boxunion_peak FILE COMMAND...: runs a command and writes the most memory that it had, in KiB, to a file.
// The tests' own process is too large to ask: the system counts its memory for a child until that has begun.

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

int main(int argc, char** argv) {
  pid_t child = 0;
  int status = 0;
  rusage usage{};
  if (argc < 3 || ::posix_spawnp(&child, argv[2], nullptr, nullptr, argv + 2, environ) != 0) return 126;
  if (::wait4(child, &status, 0, &usage) != child) return 126;
  std::FILE* file = std::fopen(argv[1], "w");
  if (!file) return 126;
  std::fprintf(file, "%ld\n", usage.ru_maxrss);
  std::fclose(file);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

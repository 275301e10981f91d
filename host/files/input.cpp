#include "host/files/input.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"

namespace boxunion {
namespace {

/// Large reads are split, so that an interrupt is noticed soon.
constexpr std::size_t kReadBytes = 8 << 20;

}  // namespace

InputFile::InputFile(const std::string& path)
    : name_(path == "-" ? "standard input" : path),
      file_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (file_ < 0) fail(errno);
  struct stat status;
  if (::fstat(file_, &status) != 0) return;
  if (S_ISDIR(status.st_mode)) {
    if (file_ != STDIN_FILENO) ::close(file_);
    fail(EISDIR);
  }
  may_wait_ = !S_ISREG(status.st_mode);
}

InputFile::~InputFile() {
  if (file_ != STDIN_FILENO) ::close(file_);
}

std::optional<std::uint64_t> InputFile::size() const {
  struct stat status;
  if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return std::uint64_t(status.st_size);
}

std::size_t InputFile::read(std::span<char> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    wait();
    const ::ssize_t got = ::read(file_, bytes.data() + done, std::min(bytes.size() - done, kReadBytes));
    if (got == 0) break;
    if (got > 0)
      done += std::size_t(got);
    else if (errno != EINTR && errno != EAGAIN)
      fail(errno);
  }
  return done;
}

std::string InputFile::read_all(std::size_t most) {
  constexpr std::size_t kBlock = 1 << 16;
  std::string text;
  for (std::size_t got = kBlock; got == kBlock;) {
    text.resize(text.size() + kBlock);
    got = read(std::span(text).last(kBlock));
    text.resize(text.size() - kBlock + got);
    if (text.size() > most)
      throw Error(ErrorKind::input, fmt::format("{}: found more than {} bytes, expected fewer", name_, most));
  }
  return text;
}

void InputFile::read_at(std::uint64_t offset, std::span<char> bytes) const {
  while (!bytes.empty()) {
    Interruptible::check();
    const ::ssize_t got = ::pread(file_, bytes.data(), std::min(bytes.size(), kReadBytes), ::off_t(offset));
    if (got == 0) throw Error(ErrorKind::input, fmt::format("{}: the file ended while it was read", name_));
    if (got > 0) {
      bytes = bytes.subspan(std::size_t(got));
      offset += std::uint64_t(got);
    } else if (errno != EINTR) {
      fail(errno);
    }
  }
}

/// Waits for data or the end of the file. A pipe that nobody has opened for writing has neither.
void InputFile::wait() const {
  constexpr int kMilliseconds = 100;
  pollfd file{file_, POLLIN, 0};
  int ready = 1;
  do {
    Interruptible::check();
    if (may_wait_) ready = ::poll(&file, 1, kMilliseconds);
  } while (ready == 0 || (ready < 0 && errno == EINTR));
}

void InputFile::fail(int error_number) const {
  throw Error(ErrorKind::input,
              fmt::format("{}: cannot read: {}", name_, std::generic_category().message(error_number)));
}

}  // namespace boxunion

#include "host/output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/error.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBufferBytes = 1 << 20;

[[noreturn]] void cannot_create(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::input, fmt::format("{}: cannot create the file: {}", path, reason));
}

/// The file that a write to `path` replaces: follows a symbolic link to an existing file.
std::string real_target(const std::string& path) {
  std::error_code ignored;
  const auto real = std::filesystem::canonical(path, ignored);
  return ignored ? path : real.string();
}

}  // namespace

OutputFile::OutputFile(std::string path, const std::atomic<bool>* interrupted)
    : path_(std::move(path)), target_(real_target(path_)), interrupted_(interrupted) {
  struct stat existing;
  if (::stat(target_.c_str(), &existing) == 0) {
    if (S_ISDIR(existing.st_mode)) cannot_create(path_, "it is a folder");
    if (!S_ISREG(existing.st_mode)) cannot_create(path_, "it exists and is not a regular file");
    if (::access(target_.c_str(), W_OK) != 0) cannot_create(path_, std::generic_category().message(errno));
  }
  const std::filesystem::path folder = std::filesystem::path(target_).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    cannot_create(
        path_, fmt::format("{} {}", folder.string(),
                           std::filesystem::exists(folder, ignored) ? "is not a folder" : "does not exist"));
  buffer_.reserve(kBufferBytes);
  for (int attempt = 0; file_ < 0; ++attempt) {
    temporary_ = fmt::format("{}.{}-{}.partial", target_, ::getpid(), attempt);
    file_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0 && errno != EEXIST) cannot_create(path_, std::generic_category().message(errno));
  }
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)),
      interrupted_(other.interrupted_),
      buffer_(std::move(other.buffer_)),
      written_(other.written_),
      file_(std::exchange(other.file_, -1)) {}

OutputFile::~OutputFile() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(temporary_.c_str());
}

void OutputFile::write(std::string_view text) {
  if (interrupted_ && *interrupted_) throw Error(ErrorKind::interrupted, "interrupted");
  if (buffer_.size() + text.size() <= kBufferBytes) {
    buffer_.append(text);
    return;
  }
  flush();
  if (text.size() < kBufferBytes) {
    buffer_.append(text);
    return;
  }
  write_at(written_, text);
  written_ += text.size();
}

void OutputFile::overwrite(std::uint64_t offset, std::string_view text) {
  flush();
  write_at(offset, text);
}

void OutputFile::flush() {
  write_at(written_, buffer_);
  written_ += buffer_.size();
  buffer_.clear();
}

void OutputFile::write_at(std::uint64_t offset, std::string_view text) {
  while (!text.empty()) {
    const ::ssize_t written = ::pwrite(file_, text.data(), text.size(), ::off_t(offset));
    if (written >= 0) {
      offset += std::uint64_t(written);
      text.remove_prefix(std::size_t(written));
    } else if (errno != EINTR) {
      fail(errno);
    } else if (interrupted_ && *interrupted_) {
      throw Error(ErrorKind::interrupted, "interrupted");
    }
  }
}

void OutputFile::commit() {
  flush();
  const bool closed = ::close(std::exchange(file_, -1)) == 0;
  if (closed && std::rename(temporary_.c_str(), target_.c_str()) == 0) return;
  const int error_number = errno;
  ::unlink(temporary_.c_str());
  fail(error_number);
}

void OutputFile::fail(int error_number) const {
  throw Error(ErrorKind::resources,
              fmt::format("{}: cannot write: {}", path_, std::generic_category().message(error_number)));
}

}  // namespace boxunion

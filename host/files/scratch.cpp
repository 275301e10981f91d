#include "host/files/scratch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"

namespace boxunion {
namespace {

/// Opens a nameless file. Negative, with errno set, if that fails.
int open_nameless(const std::string& folder) {
#ifdef O_TMPFILE
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || errno == ENOENT || errno == ENOTDIR || errno == EACCES) return file;
#endif
  std::string path = folder + "/boxunion-XXXXXX";  // for file systems without nameless files
  const int named = ::mkostemp(path.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(path.c_str());
  return named;
}

}  // namespace

ScratchFile::ScratchFile(const std::string& folder) : folder_(folder), file_(open_nameless(folder)) {
  if (file_ < 0)
    throw Error(ErrorKind::input, fmt::format("{}: cannot create scratch files: {}", folder,
                                              std::generic_category().message(errno)));
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : folder_(std::move(other.folder_)), file_(std::exchange(other.file_, -1)), size_(other.size_.load()) {}

ScratchFile::~ScratchFile() {
  if (file_ >= 0) ::close(file_);
}

std::uint64_t ScratchFile::append(std::span<const char> bytes) {
  const std::uint64_t offset = size_.fetch_add(bytes.size());
  for (std::uint64_t at = offset; !bytes.empty();) {
    Interruptible::check();
    const ::ssize_t written = ::pwrite(file_, bytes.data(), bytes.size(), ::off_t(at));
    if (written >= 0) {
      bytes = bytes.subspan(std::size_t(written));
      at += std::uint64_t(written);
    } else if (errno != EINTR) {
      fail("write", errno);
    }
  }
  return offset;
}

void ScratchFile::read_at(std::uint64_t offset, std::span<char> bytes) const {
  while (!bytes.empty()) {
    Interruptible::check();
    const ::ssize_t got = ::pread(file_, bytes.data(), bytes.size(), ::off_t(offset));
    if (got > 0) {
      bytes = bytes.subspan(std::size_t(got));
      offset += std::uint64_t(got);
    } else if (got == 0 || errno != EINTR) {
      fail("read", got == 0 ? EIO : errno);
    }
  }
}

void ScratchFile::fail(const char* action, int error_number) const {
  throw Error(ErrorKind::resources, fmt::format("{}: cannot {} scratch files: {}", folder_, action,
                                                std::generic_category().message(error_number)));
}

std::string default_scratch_folder() {
  const char* folder = ::getenv("TMPDIR");
  return folder != nullptr && *folder != '\0' ? folder : "/tmp";
}

}  // namespace boxunion

#include "host/files/pending_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

/// A path of an open file that can be used to link it.
std::string path_of(const Descriptor& file) {
  return fmt::format("/proc/self/fd/{}", file.get());
}

/// The end of a chain of symbolic links. A loop stays a link.
std::filesystem::path follow_links(std::filesystem::path path) {
  constexpr int kMostLinks = 40;  // the limit of the system
  for (int links = 0; links < kMostLinks; ++links) {
    std::error_code no_link;
    const std::filesystem::path next = std::filesystem::read_symlink(path, no_link);
    if (no_link) break;
    path = path.parent_path() / next;
  }
  return path;
}

/// True if this user may replace a file in a folder. In a sticky folder such as /tmp, only root and the
/// owners of the folder and of the file may.
bool may_replace(const struct stat& file, const struct stat& folder) {
  const ::uid_t user = ::geteuid();
  return !(folder.st_mode & S_ISVTX) || user == 0 || user == folder.st_uid || user == file.st_uid;
}

/// Opens a nameless file that can be given a name later. Returns nothing if the system does not support that.
Descriptor open_nameless([[maybe_unused]] const Descriptor& folder, [[maybe_unused]] ::mode_t mode) {
#ifdef O_TMPFILE
  Descriptor file(::openat(folder.get(), ".", O_TMPFILE | O_WRONLY | O_CLOEXEC, mode));
  if (file && ::access(path_of(file).c_str(), F_OK) == 0) return file;
#endif
  return Descriptor();
}

/// The n-th name to try for a temporary file. It is short, so that it fits wherever the name of the target
/// does.
std::string temporary_name(int attempt) {
  return fmt::format("boxunion-{}-{}.partial", ::getpid(), attempt);
}

/// Replaces the access control list of a file by that of another file. Returns false if that fails.
bool copy_access_list(const std::string& from, const Descriptor& to) {
  constexpr const char* kList = "system.posix_acl_access";
  std::string list(1 << 16, '\0');  // the limit of the system
  const ::ssize_t size = ::getxattr(from.c_str(), kList, list.data(), list.size());
  if (size > 0) return ::fsetxattr(to.get(), kList, list.data(), std::size_t(size), 0) == 0;
  return ::fremovexattr(to.get(), kList) == 0 || errno == ENODATA || errno == ENOTSUP;
}

}  // namespace

PendingFile::PendingFile(std::string path) : path_(std::move(path)) {
  const std::filesystem::path target = follow_links(path_);
  name_ = target.filename();
  const std::string folder = target.has_parent_path() ? target.parent_path() : ".";
  folder_ = Descriptor(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!folder_ && errno == ENOENT) cannot_create(folder + " does not exist");
  if (!folder_ && errno == ENOTDIR) cannot_create(folder + " is not a folder");
  if (!folder_) cannot_create(std::generic_category().message(errno));
  struct stat parent, old;
  if (::fstat(folder_.get(), &parent) != 0) cannot_create(std::generic_category().message(errno));
  ::mode_t mode = 0666;
  if (::fstatat(folder_.get(), name_.empty() ? "." : name_.c_str(), &old, AT_SYMLINK_NOFOLLOW) == 0) {
    if (S_ISDIR(old.st_mode)) cannot_create("it is a folder");
    if (S_ISLNK(old.st_mode)) cannot_create(std::generic_category().message(ELOOP));
    if (!S_ISREG(old.st_mode)) cannot_create("it exists and is not a regular file");
    if (::faccessat(folder_.get(), name_.c_str(), W_OK, 0) != 0)
      cannot_create(std::generic_category().message(errno));
    if (!may_replace(old, parent))
      cannot_create("it belongs to another user, and only that user may replace it in this folder");
    mode &= old.st_mode;  // a file that others may not read is not readable under a temporary name either
    target_ = {old.st_dev, old.st_ino, ""};
  } else {
    if (errno != ENOENT) cannot_create(std::generic_category().message(errno));
    target_ = {parent.st_dev, parent.st_ino, name_};
  }
  file_ = open_nameless(folder_, mode);
  if (!file_) open_named(mode);
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : path_(std::move(other.path_)),
      name_(std::move(other.name_)),
      temporary_(std::exchange(other.temporary_, {})),
      folder_(std::move(other.folder_)),
      file_(std::move(other.file_)),
      target_(std::move(other.target_)) {}

PendingFile::~PendingFile() {
  if (!temporary_.empty()) ::unlinkat(folder_.get(), temporary_.c_str(), 0);
}

void PendingFile::open_named(::mode_t mode) {
  for (int attempt = 0; !file_; ++attempt) {
    const std::string name = temporary_name(attempt);
    file_ = Descriptor(::openat(folder_.get(), name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
    if (file_)
      temporary_ = name;
    else if (errno != EEXIST)
      cannot_create(std::generic_category().message(errno));
  }
}

std::size_t PendingFile::write_at(std::uint64_t offset, std::string_view bytes) {
  const ::ssize_t written = ::pwrite(file_.get(), bytes.data(), bytes.size(), ::off_t(offset));
  if (written < 0 && errno != EINTR) fail(errno);
  return written < 0 ? 0 : std::size_t(written);
}

void PendingFile::check_written() const {
  const int copy = ::fcntl(file_.get(), F_DUPFD_CLOEXEC, 0);  // to close it reports errors
  if (copy < 0 || ::close(copy) != 0) fail(errno);
}

void PendingFile::publish() {
  struct stat old;
  if (::fstatat(folder_.get(), name_.c_str(), &old, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(old.st_mode))
    take_permissions_of(old);
  if (!temporary_.empty() || !link(name_)) {
    for (int attempt = 0; temporary_.empty(); ++attempt)  // only a named file can replace another
      if (const std::string name = temporary_name(attempt); link(name)) temporary_ = name;
    if (::renameat(folder_.get(), temporary_.c_str(), folder_.get(), name_.c_str()) != 0) fail(errno);
    temporary_.clear();
  }
  file_ = Descriptor();
}

bool PendingFile::link(const std::string& name) const {
  if (::linkat(AT_FDCWD, path_of(file_).c_str(), folder_.get(), name.c_str(), AT_SYMLINK_FOLLOW) == 0)
    return true;
  if (errno != EEXIST) fail(errno);
  return false;
}

void PendingFile::take_permissions_of(const struct stat& old) {
  ::mode_t mode = old.st_mode & 07777;
  bool has_group = true;
  if (::fchown(file_.get(), old.st_uid, old.st_gid) != 0) {  // only root can give files away
    mode &= 0777;
    has_group = ::fchown(file_.get(), ::uid_t(-1), old.st_gid) == 0;
  }
  const ::mode_t mode_for_strangers = mode & ~(070u & ~((mode & 07u) << 3));
  ::fchmod(file_.get(), mode_for_strangers);
  const bool has_list = has_group && copy_access_list(fmt::format("{}/{}", path_of(folder_), name_), file_);
  if (has_list) ::fchmod(file_.get(), mode);  // otherwise the group may not do more than everybody
}

void PendingFile::cannot_create(const std::string& reason) const {
  throw Error(ErrorKind::input, fmt::format("{}: cannot create the file: {}", path_, reason));
}

void PendingFile::fail(int error_number) const {
  throw Error(ErrorKind::resources,
              fmt::format("{}: cannot write: {}", path_, std::generic_category().message(error_number)));
}

}  // namespace boxunion

#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "host/files/descriptor.hpp"

namespace boxunion {

/// A new file that waits for its name. It is nameless if the system supports that, so nothing is left of it
/// however the process ends. Otherwise it has a temporary name in the same folder, which the destructor
/// removes.
class PendingFile {
 public:
  /// Opens a file that is to become `path`. Symbolic links are followed, even if the target does not exist
  /// yet. Throws Error(input) if no file can be created there, or if there is something that is not a regular
  /// file.
  explicit PendingFile(std::string path);
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&&) = delete;
  ~PendingFile();

  const std::string& path() const { return path_; }

  /// The file to be replaced. Two paths to the same file have equal targets.
  struct Target {
    ::dev_t device;
    ::ino_t inode;     ///< of the existing file, otherwise of its folder
    std::string name;  ///< in that folder, if no file exists
    friend bool operator==(const Target&, const Target&) = default;
  };
  const Target& target() const { return target_; }

  /// Writes as many bytes from an offset on as the system accepts at once. Returns their number, which is 0
  /// if a signal came first. Throws Error(resources) if the disk is full or fails.
  std::size_t write_at(std::uint64_t offset, std::string_view bytes);

  /// Throws Error(resources) if the system has lost bytes that it had accepted.
  void check_written() const;

  /// Gives the file its name. If it replaces a file, it gets the owner, group, permissions and access control
  /// list of that file, as far as the system permits. Throws Error(resources).
  void publish();

 private:
  [[noreturn]] void cannot_create(const std::string& reason) const;
  [[noreturn]] void fail(int error_number) const;
  void open_named(::mode_t mode);
  /// Gives the file a name in its folder. Returns false if another file has that name.
  bool link(const std::string& name) const;
  void take_permissions_of(const struct stat& old);

  std::string path_;
  std::string name_;       ///< of the target in its folder
  std::string temporary_;  ///< temporary name in the same folder; empty if none
  Descriptor folder_, file_;
  Target target_;
};

}  // namespace boxunion

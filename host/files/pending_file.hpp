#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "host/files/descriptor.hpp"

namespace boxunion {

/// A new file that waits for its name. Where the system has files without a name, it is one, so however the
/// process ends, nothing is left of it. Elsewhere it has a temporary name in the same folder, which is gone
/// when the object is.
class PendingFile {
 public:
  /// Opens a file that is to become `path`. Symbolic links are followed, also to what is not there yet.
  /// Throws Error(input) if no file can be made there, or if there is something that is not a regular file.
  explicit PendingFile(std::string path);
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&&) = delete;
  ~PendingFile();

  const std::string& path() const { return path_; }

  /// What is to be replaced: equal for two paths to the same file.
  struct Target {
    ::dev_t device;
    ::ino_t inode;     ///< of the file that is there, else of its folder
    std::string name;  ///< in that folder, if no file is there
    friend bool operator==(const Target&, const Target&) = default;
  };
  const Target& target() const { return target_; }

  /// Writes from an offset on as many bytes as the system takes at once, and returns their number: 0 if a
  /// signal came first. Throws Error(resources) where the disk is full or fails.
  std::size_t write_at(std::uint64_t offset, std::string_view bytes);

  /// Throws Error(resources) if the system has lost something that it had taken.
  void check_written() const;

  /// Gives the file its name. If it replaces a file, it gets that file's owner, group, permissions and access
  /// control list, as far as the system permits. Throws Error(resources).
  void publish();

 private:
  [[noreturn]] void cannot_create(const std::string& reason) const;
  [[noreturn]] void fail(int error_number) const;
  void open_named(::mode_t mode);
  /// Gives the file a name in its folder; false if another file has it.
  bool link(const std::string& name) const;
  void take_permissions_of(const struct stat& old);

  std::string path_;
  std::string name_;       ///< of the target in its folder
  std::string temporary_;  ///< name until then, in the same folder; empty: none
  Descriptor folder_, file_;
  Target target_;
};

}  // namespace boxunion

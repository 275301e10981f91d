#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/pending_file.hpp"

namespace boxunion {

/// Output files that get their names together, when all of them are complete and everything else has
/// succeeded. A group must outlive the files that are opened in it.
class OutputGroup {
 public:
  OutputGroup() = default;
  OutputGroup(const OutputGroup&) = delete;
  OutputGroup& operator=(const OutputGroup&) = delete;

  /// Gives the committed files their names.
  void publish();

 private:
  friend class OutputFile;
  /// Throws Error(usage) if another file of the group has the same target.
  void enter(const PendingFile& file);

  std::vector<std::pair<std::string, PendingFile::Target>> entered_;  ///< targets with their paths
  std::vector<PendingFile> committed_;
};

/// A file that appears under its name only when it is complete: see PendingFile.
class OutputFile {
 public:
  /// Opens the file at once, so that a missing or read-only folder is found before any heavy work. In a
  /// group, the file gets its name when the group is published. Throws Error(input) if the file cannot be
  /// created, or if `path` names something that is not a regular file, and Error(usage) if it is another file
  /// of the group.
  explicit OutputFile(std::string path, OutputGroup* group = nullptr);

  const std::string& path() const { return file_.path(); }
  /// The number of bytes appended so far.
  std::uint64_t size() const { return written_ + buffer_.size(); }

  /// Appends text. Interruptible. Throws Error(resources) if the disk is full or fails.
  void write(std::string_view text);
  /// Appends the bytes of an array.
  template <class T>
  void write_array(std::span<const T> values) {
    write({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  }

  /// Overwrites bytes appended before, from an offset on. Throws as write does.
  void overwrite(std::uint64_t offset, std::string_view text);

  /// Writes the remaining bytes and gives the file its name, replacing any file of that name; in a group, the
  /// group does that. Nothing may be written afterwards.
  void commit();

 private:
  void flush();
  void write_at(std::uint64_t offset, std::string_view text);

  PendingFile file_;
  OutputGroup* group_;
  std::string buffer_;         ///< appended, not yet written
  std::uint64_t written_ = 0;  ///< number of bytes before the buffer
};

}  // namespace boxunion

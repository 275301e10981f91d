#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/pending_file.hpp"

namespace boxunion {

/// Output files that get their names together, when all of them are complete and all else has succeeded. It
/// outlives those that are opened in it.
class OutputGroup {
 public:
  OutputGroup() = default;
  OutputGroup(const OutputGroup&) = delete;
  OutputGroup& operator=(const OutputGroup&) = delete;

  /// Gives the files that were committed their names.
  void publish();

 private:
  friend class OutputFile;
  /// Throws Error(usage) if a file of the group is to have the same name.
  void enter(const PendingFile& file);

  std::vector<std::pair<std::string, PendingFile::Target>> entered_;  ///< with their paths
  std::vector<PendingFile> committed_;
};

/// A file that appears under its name only when it is complete: see PendingFile.
class OutputFile {
 public:
  /// Opens the file, so that a missing or read-only folder is found before any heavy work. Where
  /// `interrupted` becomes true, the next write throws Error(interrupted). In a group it gets its name when
  /// that is published. Throws Error(input) if the file cannot be created, or if `path` names something that
  /// is not a regular file, and Error(usage) if it is another file of the group.
  explicit OutputFile(std::string path, const std::atomic<bool>* interrupted = nullptr,
                      OutputGroup* group = nullptr);

  const std::string& path() const { return file_.path(); }
  /// The bytes appended so far.
  std::uint64_t size() const { return written_ + buffer_.size(); }

  /// Appends; throws Error(resources) where the disk is full or fails.
  void write(std::string_view text);
  /// Appends the bytes of an array.
  template <class T>
  void write_array(std::span<const T> values) {
    write({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  }

  /// Writes over bytes appended before, from an offset; throws as write does.
  void overwrite(std::uint64_t offset, std::string_view text);

  /// Writes what is left and gives the file its name, in place of any file that had it, or leaves that to its
  /// group. Nothing follows.
  void commit();

 private:
  void flush();
  void write_at(std::uint64_t offset, std::string_view text);

  PendingFile file_;
  const std::atomic<bool>* interrupted_;
  OutputGroup* group_;
  std::string buffer_;         ///< appended, not written yet
  std::uint64_t written_ = 0;  ///< bytes before these
};

}  // namespace boxunion

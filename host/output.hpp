#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace boxunion {

/// A file that appears under its name only when it is complete: it is written under a temporary name in the
/// same folder, and removed again if anything fails before commit().
class OutputFile {
 public:
  /// Opens the temporary file, so that a missing or read-only folder is found before any heavy work. Where
  /// `interrupted` becomes true, the next write throws Error(interrupted). Throws Error(input) if the file
  /// cannot be created, or if `path` names something that is not a regular file.
  explicit OutputFile(std::string path, const std::atomic<bool>* interrupted = nullptr);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  const std::string& path() const { return path_; }
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

  /// Writes what is left and gives the file its name, in place of any file that had it.
  void commit();

 private:
  void flush();
  void write_at(std::uint64_t offset, std::string_view text);
  [[noreturn]] void fail(int error_number) const;

  std::string path_, target_, temporary_;
  const std::atomic<bool>* interrupted_;
  std::string buffer_;         ///< appended, not written yet
  std::uint64_t written_ = 0;  ///< bytes before these
  int file_ = -1;
};

}  // namespace boxunion

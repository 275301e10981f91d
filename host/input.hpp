#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace boxunion {

/// A file open for reading, or standard input.
class InputFile {
 public:
  /// `path` "-" is standard input. Where `interrupted` becomes true, the next read throws
  /// Error(interrupted). Throws Error(input) if there is no such file, or it is a folder or unreadable.
  explicit InputFile(const std::string& path, const std::atomic<bool>* interrupted = nullptr);
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// What messages call it: the path, or "standard input".
  const std::string& name() const { return name_; }
  /// Size in bytes of a regular file, nothing for a pipe.
  std::optional<std::uint64_t> size() const;

  /// Fills `bytes` from the current position; returns how many it got: fewer only at the end of the file.
  std::size_t read(std::span<char> bytes);
  /// Everything from the current position to the end.
  std::string read_all();
  /// Fills `bytes` from `offset` of a regular file; throws Error(input) at the end of it. Thread-safe.
  void read_at(std::uint64_t offset, std::span<char> bytes) const;

 private:
  void check_interrupted() const;
  [[noreturn]] void fail(int error_number) const;

  std::string name_;
  const std::atomic<bool>* interrupted_;
  int file_;
};

}  // namespace boxunion

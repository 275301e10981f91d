#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace boxunion {

/// A file open for reading, or standard input.
class InputFile {
 public:
  /// A `path` of "-" is standard input. Reading is interruptible within a fraction of a second, even while it
  /// waits for a pipe: see Interruptible. Throws Error(input) if there is no such file, or if it is a folder
  /// or unreadable.
  explicit InputFile(const std::string& path);
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// The name in messages: the path, or "standard input".
  const std::string& name() const { return name_; }
  /// Size in bytes of a regular file; nothing for a pipe.
  std::optional<std::uint64_t> size() const;

  /// Fills `bytes` from the current position and returns the number of bytes read, which is less only at the
  /// end of the file.
  std::size_t read(std::span<char> bytes);
  /// Everything from the current position to the end. Throws Error(input) if this is more than `most` bytes.
  std::string read_all(std::size_t most);
  /// Fills `bytes` from `offset` of a regular file; throws Error(input) at the end of it. Thread-safe.
  void read_at(std::uint64_t offset, std::span<char> bytes) const;

 private:
  void wait() const;
  [[noreturn]] void fail(int error_number) const;

  std::string name_;
  int file_;
  bool may_wait_ = false;  ///< a pipe, a terminal or a socket
};

}  // namespace boxunion

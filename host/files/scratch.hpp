#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>

namespace boxunion {

/// A file for data that does not fit memory. It has no name, so nothing is left of it however the process
/// ends.
class ScratchFile {
 public:
  /// Throws Error(input) if no file can be created in `folder`. Reads and writes are interruptible.
  explicit ScratchFile(const std::string& folder);
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&&) = delete;
  ~ScratchFile();

  std::uint64_t size() const { return size_; }
  /// Appends bytes and returns their offset. Throws Error(resources) if the disk is full or fails.
  /// Thread-safe: the bytes of one call stay together.
  std::uint64_t append(std::span<const char> bytes);
  /// Fills `bytes` from `offset` on with what was appended there. Thread-safe.
  void read_at(std::uint64_t offset, std::span<char> bytes) const;

 private:
  [[noreturn]] void fail(const char* action, int error_number) const;

  std::string folder_;
  int file_ = -1;
  std::atomic<std::uint64_t> size_ = 0;
};

/// $TMPDIR, or /tmp if it is not set.
std::string default_scratch_folder();

}  // namespace boxunion

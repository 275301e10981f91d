#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/files/output.hpp"

namespace boxunion {

/// Writes a ZIP archive of deflated entries, part by part, to a file. Blocks of an entry are deflated in
/// parallel; the archive depends on their content alone, not on threads, times or how it came in parts. It is
/// ZIP64 only where a size needs that.
///
/// Source: PKWARE, .ZIP File Format Specification (APPNOTE.TXT).
class ZipWriter {
 public:
  /// Numbers above `most_plain` are written as ZIP64.
  explicit ZipWriter(OutputFile& file, std::uint64_t most_plain = 0xfffffffe)
      : file_(file), most_plain_(most_plain) {}

  /// Begins an entry; the one before is complete.
  void begin(std::string name);
  /// Appends to the entry; throws as OutputFile::write does.
  void write(std::string_view bytes);
  /// Completes the last entry and the archive.
  void finish();

 private:
  struct Entry {
    std::string name;
    std::uint64_t offset, compressed = 0, size = 0;
    std::uint32_t crc = 0;
  };

  bool is_large(const Entry& entry) const;
  std::string local_header(const Entry& entry) const;
  std::string directory_header(const Entry& entry) const;
  void end_entry();
  /// Deflates what waits in blocks of their full size, but for the last ones of an entry.
  void deflate_blocks(bool last);

  OutputFile& file_;
  std::uint64_t most_plain_;
  std::vector<Entry> entries_;
  std::string waiting_;                ///< bytes to be deflated
  std::vector<std::string> deflated_;  ///< its blocks, kept for their memory
};

}  // namespace boxunion

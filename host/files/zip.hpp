#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/files/output.hpp"

namespace boxunion {

/// Writes a ZIP archive of deflated entries to a file, part by part. Blocks of an entry are deflated in
/// parallel. The archive depends only on the contents, not on threads, times or the sizes of the parts. It is
/// ZIP64 only if a size needs that.
///
/// Source: PKWARE, .ZIP File Format Specification (APPNOTE.TXT).
class ZipWriter {
 public:
  /// Numbers above `most_plain` are written as ZIP64.
  explicit ZipWriter(OutputFile& file, std::uint64_t most_plain = 0xfffffffe)
      : file_(file), most_plain_(most_plain) {}

  /// Begins an entry; the one before is complete.
  void begin(std::string name);
  /// Appends to the entry. Throws as OutputFile::write does.
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
  /// Deflates the waiting bytes in blocks of full size; only the last blocks of an entry may be shorter.
  void deflate_blocks(bool last);

  OutputFile& file_;
  std::uint64_t most_plain_;
  std::vector<Entry> entries_;
  std::string waiting_;                ///< bytes to be deflated
  std::vector<std::string> deflated_;  ///< its blocks, kept for their memory
};

}  // namespace boxunion

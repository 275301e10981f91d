#include "host/files/zip.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <new>
#include <utility>

#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are");

constexpr std::size_t kBlockBytes = 1 << 17, kBlocks = 32;  // blocks that are deflated together

constexpr std::uint16_t kPlainVersion = 20, kLargeVersion = 45, kDeflated = 8;
constexpr std::uint32_t kDate = 0x0021'0000;  // 1980-01-01, the earliest date of the format
constexpr std::uint16_t kZip64 = 1;           // extra field with 64-bit numbers
constexpr std::uint16_t kReserved = 0x9999;   // extra field as reserve, as 3MF recommends
constexpr std::uint32_t kSee64 = 0xffffffff;

/// Appends numbers, each in its own width.
template <class... Ts>
void put(std::string& bytes, Ts... values) {
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

/// Deflates a block that refers to no earlier block. It ends at a byte, so that another block may follow.
void deflate_block(std::string_view block, bool last, std::string& deflated) {
  struct Stream : z_stream {
    Stream() : z_stream() {
      if (deflateInit2(this, Z_BEST_SPEED, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    }
    ~Stream() { deflateEnd(this); }
  } stream;
  constexpr std::size_t kMarker = 16;  // more than an empty block
  deflated.resize(deflateBound(&stream, uLong(block.size())) + kMarker);
  stream.next_in = reinterpret_cast<const Bytef*>(block.data());
  stream.avail_in = static_cast<uInt>(block.size());
  stream.next_out = reinterpret_cast<Bytef*>(deflated.data());
  stream.avail_out = static_cast<uInt>(deflated.size());
  deflate(&stream, last ? Z_FINISH : Z_SYNC_FLUSH);
  deflated.resize(stream.total_out);
}

std::uint32_t crc_of(std::string_view bytes) {
  return std::uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

bool ZipWriter::is_large(const Entry& entry) const {
  return std::max({entry.offset, entry.compressed, entry.size}) > most_plain_;
}

std::string ZipWriter::local_header(const Entry& entry) const {
  const bool large = is_large(entry);
  const auto plain = [&](std::uint64_t number) { return large ? kSee64 : std::uint32_t(number); };
  std::string header = "PK\3\4";
  put(header, large ? kLargeVersion : kPlainVersion, std::uint16_t{0}, kDeflated, kDate, entry.crc,
      plain(entry.compressed), plain(entry.size), std::uint16_t(entry.name.size()), std::uint16_t{20});
  header += entry.name;
  put(header, large ? kZip64 : kReserved, std::uint16_t{16}, entry.size, entry.compressed);
  return header;
}

std::string ZipWriter::directory_header(const Entry& entry) const {
  const bool large = is_large(entry);
  const auto plain = [&](std::uint64_t number) { return large ? kSee64 : std::uint32_t(number); };
  const std::uint16_t version = large ? kLargeVersion : kPlainVersion;
  std::string header = "PK\1\2";
  put(header, version, version, std::uint16_t{0}, kDeflated, kDate, entry.crc, plain(entry.compressed),
      plain(entry.size), std::uint16_t(entry.name.size()), std::uint16_t(large ? 28 : 0));
  header.append(10, '\0');  // comment, disk, attributes
  put(header, plain(entry.offset));
  header += entry.name;
  if (large) put(header, kZip64, std::uint16_t{24}, entry.size, entry.compressed, entry.offset);
  return header;
}

void ZipWriter::begin(std::string name) {
  end_entry();
  entries_.push_back({.name = std::move(name), .offset = file_.size()});
  file_.write(local_header(entries_.back()));
}

void ZipWriter::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t some = std::min(bytes.size(), kBlocks * kBlockBytes - waiting_.size());
    waiting_.append(bytes.substr(0, some));
    bytes.remove_prefix(some);
    if (waiting_.size() == kBlocks * kBlockBytes) deflate_blocks(false);
  }
}

void ZipWriter::deflate_blocks(bool last) {
  Entry& entry = entries_.back();
  const std::size_t blocks = std::max<std::size_t>(1, (waiting_.size() + kBlockBytes - 1) / kBlockBytes);
  const auto block = [&](std::size_t i) {
    return std::string_view(waiting_).substr(i * kBlockBytes, kBlockBytes);
  };
  deflated_.resize(std::max(blocks, deflated_.size()));
  std::vector<std::uint32_t> crcs(blocks);
  parallel_for_each(0, blocks, 1, [&](std::size_t i) {
    deflate_block(block(i), last && i + 1 == blocks, deflated_[i]);
    crcs[i] = crc_of(block(i));
  });
  for (std::size_t i = 0; i < blocks; ++i) {
    file_.write(deflated_[i]);
    entry.compressed += deflated_[i].size();
    entry.size += block(i).size();
    entry.crc = std::uint32_t(crc32_combine(entry.crc, crcs[i], z_off_t(block(i).size())));
  }
  waiting_.clear();
}

void ZipWriter::end_entry() {
  if (entries_.empty()) return;
  deflate_blocks(true);
  file_.overwrite(entries_.back().offset, local_header(entries_.back()));
}

void ZipWriter::finish() {
  end_entry();
  const std::uint64_t offset = file_.size();
  std::string directory;
  for (const Entry& entry : entries_) directory += directory_header(entry);
  const std::uint64_t size = directory.size(), count = entries_.size();
  const bool large = offset > most_plain_;
  if (large) {
    const std::uint64_t end = offset + size;
    directory += "PK\6\6";
    put(directory, std::uint64_t{44}, kLargeVersion, kLargeVersion, std::uint64_t{0}, count, count, size,
        offset);
    directory += "PK\6\7";
    put(directory, std::uint32_t{0}, end, std::uint32_t{1});
  }
  directory += "PK\5\6";
  put(directory, std::uint32_t{0}, std::uint16_t(count), std::uint16_t(count), std::uint32_t(size),
      large ? kSee64 : std::uint32_t(offset), std::uint16_t{0});
  file_.write(directory);
}

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "boxunion/volume.hpp"
#include "host/files/input.hpp"

// The numbers of a volume, for all readers of volumes.

namespace boxunion {

/// Type of a number in a file.
enum class Element { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

std::size_t element_size(Element element);

/// Decides which voxels are inside: those of value >= threshold or, without a threshold, those that are not
/// 0. NaN is outside.
class InsideTest {
 public:
  /// `swapped`: the numbers have the other byte order than this machine.
  InsideTest(Element element, bool swapped, std::optional<double> threshold);
  /// Sets inside[i] to 1 or 0 for number i of `numbers`. Parallel.
  void operator()(std::span<const char> numbers, std::span<std::uint8_t> inside) const;

 private:
  std::size_t size_;
  std::function<void(const char* numbers, std::size_t count, std::uint8_t* inside)> test_;
};

/// Where the numbers of a volume are: in a file from `offset` on, one after the other, possibly compressed.
struct VoxelData {
  std::shared_ptr<const InputFile> file;
  std::uint64_t offset = 0;
  bool is_compressed = false;                    ///< by zlib or gzip
  std::optional<std::uint64_t> compressed_size;  ///< in bytes; if missing, up to the end of the file
  Element element = Element::u8;
  bool big_endian = false;
};

/// The first characters of a text in a file, for messages.
std::string shortened(std::string_view text);

/// Throws Error(input) that names the file.
[[noreturn]] void reject(const InputFile& file, const std::string& problem);

/// Size in bytes of a file that must not be a pipe.
std::uint64_t regular_size(const InputFile& file);

/// Throws Error(input) unless each extent is 1 to 2^31 - 1 and all voxels together fit 60 bits.
void check_extents(const InputFile& file, const std::array<std::uint64_t, 3>& extents);

/// Throws Error(input) if `bytes` bytes cannot come from `compressed` bytes at a ratio of at most `ratio`.
void check_ratio(const InputFile& file, std::uint64_t bytes, std::uint64_t compressed, std::uint64_t ratio);

/// A stream of the voxels of `grid`. Throws Error(input), at once or while it is read, if the file has fewer
/// or more numbers, or broken compressed data. Never allocates more memory than the file can hold voxels for.
VoxelStream stream_voxels(const VoxelGrid& grid, const VoxelData& data, std::optional<double> threshold);

}  // namespace boxunion

#include "host/files/voxel_data.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBytesAtOnce = std::size_t{1} << 22;  ///< a multiple of every element size
constexpr std::uint64_t kDeflateRatio = 1032;               ///< no zlib stream expands more

template <class F>
decltype(auto) visit(Element element, F&& f) {
  switch (element) {
    case Element::u8:
      return f(std::uint8_t{});
    case Element::i8:
      return f(std::int8_t{});
    case Element::u16:
      return f(std::uint16_t{});
    case Element::i16:
      return f(std::int16_t{});
    case Element::u32:
      return f(std::uint32_t{});
    case Element::i32:
      return f(std::int32_t{});
    case Element::u64:
      return f(std::uint64_t{});
    case Element::i64:
      return f(std::int64_t{});
    case Element::f32:
      return f(float{});
    case Element::f64:
      break;
  }
  return f(double{});
}

template <class T>
T load(const char* at, bool swapped) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Sets inside[i] to is_inside(number i).
template <class T, class F>
auto test_each(bool swapped, F is_inside) {
  return [=](const char* numbers, std::size_t count, std::uint8_t* inside) {
    const auto test = [&](bool swap) {
      for (std::size_t i = 0; i < count; ++i) inside[i] = is_inside(load<T>(numbers + i * sizeof(T), swap));
    };
    swapped ? test(true) : test(false);
  };
}

/// A sequence of bytes.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills `bytes` and returns the number of bytes read, which is less only at the end.
  virtual std::size_t read(std::span<char> bytes) = 0;
};

class FileBytes final : public ByteSource {
 public:
  FileBytes(std::shared_ptr<const InputFile> file, std::uint64_t begin, std::uint64_t end)
      : file_(std::move(file)), at_(begin), end_(end) {}

  std::size_t read(std::span<char> bytes) override {
    const auto count = std::size_t(std::min<std::uint64_t>(bytes.size(), end_ - at_));
    file_->read_at(at_, bytes.first(count));
    at_ += count;
    return count;
  }

 private:
  std::shared_ptr<const InputFile> file_;
  std::uint64_t at_, end_;
};

/// The contents of zlib or gzip streams, one after the other.
class InflatedBytes final : public ByteSource {
 public:
  InflatedBytes(std::shared_ptr<const InputFile> file, std::uint64_t begin, std::uint64_t end)
      : file_(file), compressed_(std::move(file), begin, end), input_(std::size_t{1} << 17) {
    constexpr int kAnyHeader = 15 + 32;  // the largest window, zlib or gzip
    if (::inflateInit2(&zlib_, kAnyHeader) != Z_OK) throw_out_of_memory("zlib", sizeof zlib_);
  }
  ~InflatedBytes() override { ::inflateEnd(&zlib_); }
  InflatedBytes(const InflatedBytes&) = delete;
  InflatedBytes& operator=(const InflatedBytes&) = delete;

  std::size_t read(std::span<char> bytes) override {
    zlib_.next_out = reinterpret_cast<Bytef*>(bytes.data());
    zlib_.avail_out = uInt(bytes.size());
    while (zlib_.avail_out > 0) {
      if (zlib_.avail_in == 0) refill();
      if (is_at_end_ && zlib_.avail_in == 0) break;
      if (std::exchange(is_at_end_, false)) ::inflateReset(&zlib_);
      const int result = ::inflate(&zlib_, Z_NO_FLUSH);
      if (result == Z_STREAM_END)
        is_at_end_ = true;
      else if (result == Z_MEM_ERROR)
        throw_out_of_memory("zlib", std::size_t{1} << 16);
      else if (result != Z_OK)
        reject(*file_, zlib_.avail_in == 0 ? "the compressed voxels are cut off"
                                           : fmt::format("the compressed voxels are broken: {}",
                                                         zlib_.msg ? zlib_.msg : "zlib cannot read them"));
    }
    return bytes.size() - zlib_.avail_out;
  }

 private:
  void refill() {
    zlib_.avail_in = uInt(compressed_.read(input_));
    zlib_.next_in = reinterpret_cast<Bytef*>(input_.data());
  }

  std::shared_ptr<const InputFile> file_;
  FileBytes compressed_;
  std::vector<char> input_;
  z_stream zlib_{};
  bool is_at_end_ = false;
};

/// Checks that the file can hold `bytes` of numbers, and opens them.
std::unique_ptr<ByteSource> open_source(const VoxelData& data, std::uint64_t bytes) {
  const InputFile& file = *data.file;
  const std::uint64_t size = regular_size(file);
  const std::uint64_t rest = size - std::min(data.offset, size);
  if (data.is_compressed) {
    const std::uint64_t compressed = data.compressed_size.value_or(rest);
    if (compressed > rest)
      reject(file, fmt::format("the file is cut off: the header says {} compressed bytes, found {}",
                               compressed, rest));
    check_ratio(file, bytes, compressed, kDeflateRatio);
    return std::make_unique<InflatedBytes>(data.file, data.offset, data.offset + compressed);
  }
  if (rest < bytes)
    reject(file, fmt::format("the file is cut off: the voxels take {} bytes, found {}", bytes, rest));
  if (rest > bytes)
    reject(file, fmt::format("found {} bytes after the {} bytes of the voxels, expected none", rest - bytes,
                             bytes));
  return std::make_unique<FileBytes>(data.file, data.offset, data.offset + bytes);
}

}  // namespace

std::size_t element_size(Element element) {
  return visit(element, [](auto number) { return sizeof number; });
}

InsideTest::InsideTest(Element element, bool swapped, std::optional<double> threshold)
    : size_(element_size(element)) {
  visit(element, [&]<class T>(T) {
    if constexpr (std::is_floating_point_v<T>) {
      if (threshold)
        test_ = test_each<T>(swapped, [t = *threshold](T value) { return double(value) >= t; });
      else
        test_ = test_each<T>(swapped, [](T value) { return value < 0 || value > 0; });
    } else {
      using Limits = std::numeric_limits<T>;
      const double bound = std::ceil(threshold.value_or(0));
      if (!threshold)
        test_ = test_each<T>(swapped, [](T value) { return value != 0; });
      else if (bound >= std::ldexp(1, Limits::digits))
        test_ = test_each<T>(swapped, [](T) { return false; });
      else if (bound <= double(Limits::min()))
        test_ = test_each<T>(swapped, [](T) { return true; });
      else
        test_ = test_each<T>(swapped, [t = T(bound)](T value) { return value >= t; });
    }
  });
}

void InsideTest::operator()(std::span<const char> numbers, std::span<std::uint8_t> inside) const {
  parallel_ranges(0, inside.size(), std::size_t{1} << 17, [&](std::size_t begin, std::size_t end) {
    test_(numbers.data() + begin * size_, end - begin, inside.data() + begin);
  });
}

std::string shortened(std::string_view text) {
  constexpr std::size_t kMost = 100;
  return text.size() <= kMost ? std::string(text) : fmt::format("{}...", text.substr(0, kMost));
}

void reject(const InputFile& file, const std::string& problem) {
  throw Error(ErrorKind::input, fmt::format("{}: {}", file.name(), problem));
}

std::uint64_t regular_size(const InputFile& file) {
  const auto size = file.size();
  if (!size) reject(file, "cannot read a volume from a pipe, expected a regular file");
  return *size;
}

void check_extents(const InputFile& file, const std::array<std::uint64_t, 3>& extents) {
  const auto [x, y, z] = extents;
  for (const std::uint64_t extent : extents)
    if (extent < 1 || extent > std::uint64_t(std::numeric_limits<std::int32_t>::max()))
      reject(file,
             fmt::format("found {} x {} x {} voxels, expected 1 to 2147483647 along each axis", x, y, z));
  if (double(x) * double(y) * double(z) > 0x1p59)
    reject(file, fmt::format("found {} x {} x {} voxels, expected fewer", x, y, z));
}

void check_ratio(const InputFile& file, std::uint64_t bytes, std::uint64_t compressed, std::uint64_t ratio) {
  if (bytes / ratio > compressed)
    reject(file, fmt::format("the file is cut off: found {} compressed bytes, too few for voxels of {} bytes",
                             compressed, bytes));
}

VoxelStream stream_voxels(const VoxelGrid& grid, const VoxelData& data, std::optional<double> threshold) {
  for (std::size_t a = 0; a < 3; ++a)
    if (!std::isfinite(grid.origin[a] + double(grid.size[a]) * grid.spacing[a]))
      reject(*data.file, fmt::format("{} voxels of {} from {} on exceed the range of double", grid.size[a],
                                     grid.spacing[a], grid.origin[a]));
  const std::size_t size = element_size(data.element);
  const bool swapped = data.big_endian != (std::endian::native == std::endian::big);
  std::shared_ptr<ByteSource> source = open_source(data, grid.voxels() * size);
  return {grid,
          [=, file = data.file, left = grid.voxels(), test = InsideTest(data.element, swapped, threshold),
           numbers = std::vector<char>()](std::span<std::uint8_t> slices) mutable {
            while (!slices.empty()) {
              numbers.resize(std::min(kBytesAtOnce, slices.size() * size));
              const std::size_t got = source->read(numbers);
              if (got < numbers.size())
                reject(*file, fmt::format("the compressed voxels end {} bytes early", left * size - got));
              test(numbers, slices.first(got / size));
              left -= got / size;
              slices = slices.subspan(got / size);
            }
            char more;
            if (left == 0 && source->read({&more, 1}) != 0)
              reject(*file, "found more compressed voxels than the header says");
          }};
}

}  // namespace boxunion

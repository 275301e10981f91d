#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/formats.hpp"
#include "host/files/voxel_data.hpp"

// libtiff: https://libtiff.gitlab.io/libtiff/functions.html

namespace boxunion::tiff {
namespace {

/// How the pages of a stack store their voxels. All pages must agree.
struct PageFormat {
  std::uint32_t width = 0, height = 0;
  Element element = Element::u8;
  friend bool operator==(const PageFormat&, const PageFormat&) = default;
};

/// Limit for the tags of a page, which libtiff holds in memory: enough for four million tiles.
constexpr std::uint64_t kMostTagBytes = std::uint64_t{1} << 26;

/// A TIFF file open in libtiff, which reads it through an InputFile and passes its messages to this object.
class Tiff {
 public:
  explicit Tiff(std::shared_ptr<const InputFile> file) : file_(std::move(file)), size_(regular_size(*file_)) {
    const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(::TIFFOpenOptionsAlloc(),
                                                                               ::TIFFOpenOptionsFree);
    ::TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &Tiff::on_error, this);
    ::TIFFOpenOptionsSetWarningHandlerExtR(
        options.get(), [](TIFF*, void*, const char*, const char*, va_list) { return 1; }, nullptr);
    handle_.reset(::TIFFClientOpenExt(
        file_->name().c_str(), "rm", this, &Tiff::read,
        [](thandle_t, void*, tmsize_t) { return tmsize_t{0}; }, &Tiff::seek, [](thandle_t) { return 0; },
        [](thandle_t user) { return self(user).size_; }, nullptr, nullptr, options.get()));
    if (!handle_) fail("not a TIFF file");
    end_tags();
  }
  Tiff(const Tiff&) = delete;
  Tiff& operator=(const Tiff&) = delete;

  const InputFile& file() const { return *file_; }
  std::uint64_t file_size() const { return size_; }
  TIFF* get() const { return handle_.get(); }

  bool is_last_page() const { return ::TIFFLastDirectory(handle_.get()); }
  /// Reads the tags of the next page.
  void next_page() {
    tag_bytes_left_ = kMostTagBytes;
    if (!::TIFFReadDirectory(handle_.get())) fail("a page cannot be read");
    end_tags();
  }
  /// Reads the tags of the first page again.
  void rewind() {
    tag_bytes_left_ = kMostTagBytes;
    if (!::TIFFSetDirectory(handle_.get(), 0)) fail("the first page cannot be read");
    end_tags();
  }

  /// A field of the current page, with the default that the format gives it.
  template <class T>
  T field(std::uint32_t tag) const {
    T value{};
    ::TIFFGetFieldDefaulted(handle_.get(), tag, &value);
    return value;
  }

  /// Throws the exception of a callback from libtiff, if there was one, otherwise Error(input) with libtiff's
  /// message.
  [[noreturn]] void fail(const std::string& problem) const {
    if (exception_) std::rethrow_exception(exception_);
    // libtiff has no error codes
    if (message_.find("llocat") != message_.npos || message_.find("ut of memory") != message_.npos)
      throw Error(ErrorKind::resources, fmt::format("{}: out of memory: {}", file_->name(), message_));
    reject(*file_, message_.empty() ? problem : fmt::format("{}: {}", problem, message_));
  }

 private:
  struct Close {
    void operator()(TIFF* handle) const { ::TIFFClose(handle); }
  };

  /// Ends the reading of tags. libtiff only warns of some tags that it cannot read.
  void end_tags() {
    tag_bytes_left_.reset();
    if (exception_) std::rethrow_exception(exception_);
  }

  static Tiff& self(thandle_t user) { return *static_cast<Tiff*>(user); }
  static tmsize_t read(thandle_t user, void* bytes, tmsize_t count) {
    Tiff& tiff = self(user);
    const std::uint64_t rest = tiff.size_ - std::min(tiff.position_, tiff.size_);
    const auto got = std::size_t(std::min(rest, std::uint64_t(count)));
    try {
      if (tiff.tag_bytes_left_) tiff.count_tags(got);
      tiff.file_->read_at(tiff.position_, {static_cast<char*>(bytes), got});
    } catch (...) {
      tiff.exception_ = std::current_exception();  // exceptions must not pass through libtiff
      return -1;
    }
    tiff.position_ += got;
    return tmsize_t(got);
  }
  void count_tags(std::uint64_t bytes) {
    if (bytes > *tag_bytes_left_)
      reject(*file_, fmt::format("the tags of a page take more than {} bytes", kMostTagBytes));
    *tag_bytes_left_ -= bytes;
  }
  static toff_t seek(thandle_t user, toff_t offset, int whence) {
    Tiff& tiff = self(user);
    const std::uint64_t base = whence == SEEK_CUR ? tiff.position_ : whence == SEEK_END ? tiff.size_ : 0;
    return tiff.position_ = base + offset;
  }
  static int on_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    char text[256];
    std::vsnprintf(text, sizeof text, format, arguments);
    Tiff& tiff = self(user);
    if (tiff.message_.empty()) tiff.message_ = text;
    return 1;
  }

  std::shared_ptr<const InputFile> file_;
  std::uint64_t size_, position_ = 0;
  std::optional<std::uint64_t> tag_bytes_left_ = kMostTagBytes;  ///< has a value while tags are read
  std::string message_;
  std::exception_ptr exception_;
  std::unique_ptr<TIFF, Close> handle_;
};

/// The format of the current page. Throws Error(input) if boxunion cannot read it, or if the file is too
/// small for it.
PageFormat page_format(const Tiff& tiff, std::size_t page) {
  const auto refuse = [&](const std::string& problem) {
    reject(tiff.file(), fmt::format("page {}: {}", page, problem));
  };
  PageFormat format;
  format.width = tiff.field<std::uint32_t>(TIFFTAG_IMAGEWIDTH);
  format.height = tiff.field<std::uint32_t>(TIFFTAG_IMAGELENGTH);
  const auto samples = tiff.field<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL);
  const auto bits = tiff.field<std::uint16_t>(TIFFTAG_BITSPERSAMPLE);
  const auto kind = tiff.field<std::uint16_t>(TIFFTAG_SAMPLEFORMAT);
  const auto compression = tiff.field<std::uint16_t>(TIFFTAG_COMPRESSION);
  if (samples != 1) refuse(fmt::format("found {} samples a pixel, expected 1: grey", samples));
  const bool is_signed = kind == SAMPLEFORMAT_INT, is_float = kind == SAMPLEFORMAT_IEEEFP;
  if (is_float && bits == 32)
    format.element = Element::f32;
  else if (is_float && bits == 64)
    format.element = Element::f64;
  else if (!is_float && bits == 8)
    format.element = is_signed ? Element::i8 : Element::u8;
  else if (!is_float && bits == 16)
    format.element = is_signed ? Element::i16 : Element::u16;
  else if (!is_float && bits == 32)
    format.element = is_signed ? Element::i32 : Element::u32;
  else
    refuse(fmt::format("found {} of {} bits, expected integers of 8, 16 or 32 bits or floats of 32 or 64",
                       is_float ? "floats" : "integers", bits));
  if (!::TIFFIsCODECConfigured(compression))
    refuse(fmt::format("found compression {}, which this libtiff cannot read", compression));
  check_extents(tiff.file(), {format.width, format.height, 1});

  std::uint64_t stored = 0;
  const bool is_tiled = ::TIFFIsTiled(tiff.get());
  const std::uint32_t pieces = is_tiled ? ::TIFFNumberOfTiles(tiff.get()) : ::TIFFNumberOfStrips(tiff.get());
  for (std::uint32_t i = 0; i < pieces && stored <= tiff.file_size(); ++i)
    stored += ::TIFFGetStrileByteCount(tiff.get(), i);
  // The maximum number of bytes that one byte expands to: 64 in PackBits, 1032 in Deflate, about 1400 in LZW,
  // 32 768 in Zstandard.
  const bool is_bounded = compression == COMPRESSION_LZW || compression == COMPRESSION_PACKBITS ||
                          compression == COMPRESSION_DEFLATE || compression == COMPRESSION_ADOBE_DEFLATE;
  const std::uint64_t ratio = compression == COMPRESSION_NONE ? 1 : is_bounded ? 2048 : 1 << 16;
  const double bytes =  // of tiles; a double, because 64 bits may overflow
      is_tiled ? double(pieces) * double(::TIFFTileSize(tiff.get()))
               : double(format.width) * double(format.height) * double(element_size(format.element));
  if (stored > tiff.file_size() || bytes / double(ratio) > double(stored))
    refuse(fmt::format("the file is cut off: the pixels take {:.0f} bytes, found {}", bytes,
                       std::min(stored, tiff.file_size())));
  return format;
}

/// Reads the current page into a slice.
void read_page(const Tiff& tiff, std::size_t page, const PageFormat& format, const InsideTest& test,
               std::span<std::uint8_t> slice, std::vector<char>& pixels) {
  const auto check = [&](tmsize_t result) {
    if (result < 0) tiff.fail(fmt::format("page {}", page));
  };
  TIFF* const handle = tiff.get();
  const std::size_t size = element_size(format.element), width = format.width, height = format.height;
  if (!::TIFFIsTiled(handle)) {
    const std::size_t rows_a_strip =
        std::min<std::size_t>(tiff.field<std::uint32_t>(TIFFTAG_ROWSPERSTRIP), height);
    pixels.resize(rows_a_strip * width * size);
    for (std::size_t y = 0, strip = 0; y < height; y += rows_a_strip, ++strip) {
      const std::size_t rows = std::min(rows_a_strip, height - y), bytes = rows * width * size;
      const tmsize_t got =
          ::TIFFReadEncodedStrip(handle, std::uint32_t(strip), pixels.data(), tmsize_t(bytes));
      check(got);
      if (std::size_t(got) < bytes) tiff.fail(fmt::format("page {}: a strip is too short", page));
      test(std::span(pixels).first(bytes), slice.subspan(y * width, rows * width));
    }
    return;
  }
  const auto tile_width = tiff.field<std::uint32_t>(TIFFTAG_TILEWIDTH);
  const auto tile_height = tiff.field<std::uint32_t>(TIFFTAG_TILELENGTH);
  pixels.resize(std::size_t(::TIFFTileSize(handle)));
  for (std::uint32_t y = 0; y < height; y += tile_height)
    for (std::uint32_t x = 0; x < width; x += tile_width) {
      check(::TIFFReadTile(handle, pixels.data(), x, y, 0, 0));
      const std::size_t columns = std::min<std::size_t>(tile_width, width - x);
      for (std::size_t row = 0; row < std::min<std::size_t>(tile_height, height - y); ++row)
        test(std::span(pixels).subspan(row * tile_width * size, columns * size),
             slice.subspan((y + row) * width + x, columns));
    }
}

/// True if a page is a slice. Pages that are smaller versions of others are not.
bool is_slice(const Tiff& tiff) {
  return (tiff.field<std::uint32_t>(TIFFTAG_SUBFILETYPE) & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
}

/// Goes to the next page that is a slice. False at the end of the file.
bool next_slice(Tiff& tiff) {
  do {
    if (tiff.is_last_page()) return false;
    tiff.next_page();
  } while (!is_slice(tiff));
  return true;
}

/// ImageJ writes more than 4 GB as one page followed by the pixels of the other pages, which libtiff cannot
/// see.
void check_imagej(const Tiff& tiff, std::size_t pages) {
  const char* description = nullptr;
  if (!::TIFFGetField(tiff.get(), TIFFTAG_IMAGEDESCRIPTION, &description) || !description) return;
  const std::string_view text = description;
  const std::size_t at = text.find("\nimages=");
  if (!text.starts_with("ImageJ=") || at == text.npos) return;
  const std::size_t images = std::strtoull(description + at + 8, nullptr, 10);
  if (images > pages)
    reject(tiff.file(), fmt::format("found {} pages of an ImageJ stack of {}, expected a page for each slice",
                                    pages, images));
}

}  // namespace

VoxelStream open_volume(std::shared_ptr<const InputFile> file, const VolumeOptions& options) {
  const auto tiff = std::make_shared<Tiff>(std::move(file));
  if (!is_slice(*tiff)) reject(tiff->file(), "the first page is a reduced image or a mask, expected a slice");
  const PageFormat format = page_format(*tiff, 1);
  std::size_t pages = 1;
  while (next_slice(*tiff)) ++pages;
  tiff->rewind();
  check_imagej(*tiff, pages);
  VoxelGrid grid;
  grid.size = {format.width, format.height, pages};
  check_extents(tiff->file(), grid.size);
  return {grid, [=, test = InsideTest(format.element, false, options.threshold), page = std::size_t{0},
                 pixels = std::vector<char>()](std::span<std::uint8_t> slices) mutable {
            for (; !slices.empty(); slices = slices.subspan(grid.slice())) {
              if (page++ > 0 && !next_slice(*tiff)) tiff->fail("a page cannot be read");
              if (const PageFormat found = page_format(*tiff, page); found != format)
                reject(
                    tiff->file(),
                    fmt::format(
                        "page {}: found {} x {} pixels of {} bytes, expected those of page 1: {} x {} of {}, "
                        "and the same type of numbers",
                        page, found.width, found.height, element_size(found.element), format.width,
                        format.height, element_size(format.element)));
              read_page(*tiff, page, format, test, slices.first(grid.slice()), pixels);
            }
          }};
}

}  // namespace boxunion::tiff

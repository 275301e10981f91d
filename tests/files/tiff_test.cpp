#ifdef BOXUNION_HAVE_TIFF

#include <gtest/gtest.h>
#include <tiffio.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "boxunion/voxels.hpp"
#include "host/files/files.hpp"
#include "tests/files/volumes.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

/// How to write a page.
struct Page {
  std::uint16_t format = SAMPLEFORMAT_UINT, compression = COMPRESSION_NONE, samples = 1;
  std::uint32_t tile = 0;  ///< edge of a tile, 0 for strips
  std::uint32_t subfile = 0;
  const char* description = nullptr;
};

class TiffStack : public testing::Test {
 protected:
  /// Writes the voxels of a volume as slices of T: 3 for inside, 0 for outside.
  template <class T>
  std::string write(const Volume& volume, const Page& page, const char* mode = "w") {
    const auto [nx, ny, nz] = volume.grid.size;
    TIFF* tiff = ::TIFFOpen(folder_.file("a.tif").c_str(), mode);
    for (std::size_t z = 0; z < nz; ++z) {
      ::TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, std::uint32_t(nx));
      ::TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, std::uint32_t(ny));
      ::TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * sizeof(T));
      ::TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, page.format);
      ::TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page.samples);
      ::TIFFSetField(tiff, TIFFTAG_COMPRESSION, page.compression);
      ::TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, page.samples == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
      ::TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
      ::TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, page.subfile);
      if (page.description) ::TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, page.description);
      const auto value = [&](std::size_t x, std::size_t y) {
        return x < nx && y < ny && volume.inside[(z * ny + y) * nx + x] ? T(3) : T(0);
      };
      if (page.tile) {
        ::TIFFSetField(tiff, TIFFTAG_TILEWIDTH, page.tile);
        ::TIFFSetField(tiff, TIFFTAG_TILELENGTH, page.tile);
        std::vector<T> tile(page.tile * page.tile);
        for (std::size_t y = 0; y < ny; y += page.tile)
          for (std::size_t x = 0; x < nx; x += page.tile) {
            for (std::size_t i = 0; i < tile.size(); ++i)
              tile[i] = value(x + i % page.tile, y + i / page.tile);
            ::TIFFWriteTile(tiff, tile.data(), std::uint32_t(x), std::uint32_t(y), 0, 0);
          }
      } else {
        ::TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3);
        std::vector<T> row(nx * page.samples);
        for (std::size_t y = 0; y < ny; ++y) {
          for (std::size_t x = 0; x < nx * page.samples; ++x) row[x] = value(x / page.samples, y);
          ::TIFFWriteScanline(tiff, row.data(), std::uint32_t(y), 0);
        }
      }
      ::TIFFWriteDirectory(tiff);
    }
    ::TIFFClose(tiff);
    return folder_.file("a.tif");
  }

  std::string error() {
    try {
      read_boxes(folder_.file("a.tif"));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      const std::string text = error.what();
      EXPECT_TRUE(text.starts_with(folder_.file("a.tif") + ": ")) << text;
      return text.substr(folder_.file("a.tif").size() + 2);
    }
    return "";
  }

  void expect_read(const Volume& expected, const VolumeOptions& options = {}) {
    const Volume found = read_volume(folder_.file("a.tif"), options);
    ASSERT_EQ(found.grid.size, expected.grid.size);
    for (std::size_t i = 0; i < expected.inside.size(); ++i)
      ASSERT_EQ(found.inside[i] != 0, expected.inside[i] != 0) << i;
  }

  TemporaryFolder folder_;
  Volume volume_ = random_volume(8);
};

TEST_F(TiffStack, IsReadInEveryTypeByteOrderLayoutAndCompression) {
  const auto check = [&]<class T>(T, std::uint16_t format) {
    for (const auto compression :
         {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_PACKBITS, COMPRESSION_ADOBE_DEFLATE})
      for (const std::uint32_t tile : {0u, 16u})
        for (const char* mode : {"wl", "wb", "w8"}) {
          SCOPED_TRACE(testing::Message() << sizeof(T) << " bytes, format " << format << ", compression "
                                          << compression << ", tile " << tile << ", " << mode);
          write<T>(volume_, {.format = format, .compression = std::uint16_t(compression), .tile = tile},
                   mode);
          expect_read(volume_);
          expect_read(volume_, {.threshold = 2.5});
          const Volume none = read_volume(folder_.file("a.tif"), {.threshold = 3.5});
          EXPECT_EQ(std::count(none.inside.begin(), none.inside.end(), 1), 0);
        }
  };
  check(std::uint8_t{}, SAMPLEFORMAT_UINT);
  check(std::int8_t{}, SAMPLEFORMAT_INT);
  check(std::uint16_t{}, SAMPLEFORMAT_UINT);
  check(std::int16_t{}, SAMPLEFORMAT_INT);
  check(std::uint32_t{}, SAMPLEFORMAT_UINT);
  check(std::int32_t{}, SAMPLEFORMAT_INT);
  check(float{}, SAMPLEFORMAT_IEEEFP);
  check(double{}, SAMPLEFORMAT_IEEEFP);
}

TEST_F(TiffStack, ReducedCopiesOfPagesAreSkipped) {
  write<std::uint8_t>(volume_, {});
  write<std::uint8_t>(volume_of(2, 2, 1, [](auto...) { return 1; }), {.subfile = FILETYPE_REDUCEDIMAGE}, "a");
  expect_read(volume_);
}

TEST_F(TiffStack, BadFilesAreNamed) {
  folder_.write("a.tif", "0,0,0,1,1,1\n");
  EXPECT_TRUE(error().starts_with("not a TIFF file: ")) << error();
  folder_.write("a.tif", "");
  EXPECT_TRUE(error().starts_with("not a TIFF file")) << error();
  write<std::uint8_t>(volume_, {.samples = 3});
  EXPECT_EQ(error(), "page 1: found 3 samples a pixel, expected 1: grey");
  write<std::uint64_t>(volume_, {});
  EXPECT_EQ(error(),
            "page 1: found integers of 64 bits, expected integers of 8, 16 or 32 bits or floats of 32 or 64");
  write<std::uint8_t>(volume_of(4, 3, 2, [](auto...) { return 1; }), {});
  write<std::uint8_t>(volume_of(4, 4, 1, [](auto...) { return 1; }), {}, "a");
  EXPECT_EQ(error(),
            "page 3: found 4 x 4 pixels of 1 bytes, expected those of page 1: 4 x 3 of 1, and the same type "
            "of numbers");
  write<std::uint8_t>(volume_of(4, 3, 2, [](auto...) { return 1; }),
                      {.description = "ImageJ=1.53\nimages=700\n"});
  EXPECT_EQ(error(), "found 2 pages of an ImageJ stack of 700, expected a page for each slice");
}

TEST_F(TiffStack, CutFilesAreErrorsWhereverTheyAreCut) {
  const Volume volume = volume_of(40, 30, 3, [](auto x, auto y, auto z) { return (x * y + z) % 7 < 3; });
  for (const auto compression : {COMPRESSION_NONE, COMPRESSION_ADOBE_DEFLATE}) {
    write<std::uint16_t>(volume, {.compression = std::uint16_t(compression)});
    const std::string whole = folder_.read("a.tif");
    ASSERT_EQ(error(), "");
    for (std::size_t size = 0; size < whole.size(); size += 41) {
      folder_.write("a.tif", whole.substr(0, size));
      EXPECT_NE(error(), "") << size << " of " << whole.size() << " bytes";
    }
  }
}

TEST_F(TiffStack, AHeaderThatClaimsMoreThanTheFileHoldsAllocatesNothing) {
  for (const auto compression : {COMPRESSION_NONE, COMPRESSION_ADOBE_DEFLATE})
    for (const std::uint16_t tag : {std::uint16_t(TIFFTAG_IMAGEWIDTH), std::uint16_t(TIFFTAG_IMAGELENGTH)}) {
      write<std::uint8_t>(volume_of(64, 64, 1, [](auto...) { return 1; }),
                          {.compression = std::uint16_t(compression)}, "wl");
      std::string file = folder_.read("a.tif");
      std::uint32_t directory;
      std::memcpy(&directory, file.data() + 4, 4);
      for (std::size_t entry = directory + 2; entry + 12 <= file.size(); entry += 12)
        if (std::memcmp(file.data() + entry, &tag, 2) == 0) {
          const std::uint16_t is_long = TIFF_LONG;
          const std::uint32_t huge = 2'000'000'000;
          std::memcpy(file.data() + entry + 2, &is_long, 2);
          std::memcpy(file.data() + entry + 8, &huge, 4);
          break;
        }
      folder_.write("a.tif", file);
      EXPECT_NE(error(), "") << compression << tag;
    }
}

/// 2^19 tiles of 2^45 bytes, whose product does not fit 64 bits.
TEST_F(TiffStack, TilesOfMoreBytesThanCanBeCountedAllocateNothing) {
  const std::vector<std::array<std::uint32_t, 3>> fields = {
      {TIFFTAG_IMAGEWIDTH, TIFF_LONG, 1},
      {TIFFTAG_IMAGELENGTH, TIFF_LONG, 1u << 30},
      {TIFFTAG_BITSPERSAMPLE, TIFF_SHORT, 64},
      {TIFFTAG_COMPRESSION, TIFF_SHORT, COMPRESSION_NONE},
      {TIFFTAG_PHOTOMETRIC, TIFF_SHORT, PHOTOMETRIC_MINISBLACK},
      {TIFFTAG_SAMPLESPERPIXEL, TIFF_SHORT, 1},
      {TIFFTAG_TILEWIDTH, TIFF_LONG, 1u << 31},
      {TIFFTAG_TILELENGTH, TIFF_LONG, 1u << 11},
      {TIFFTAG_TILEOFFSETS, TIFF_LONG, 8},
      {TIFFTAG_TILEBYTECOUNTS, TIFF_LONG, 100},
      {TIFFTAG_SAMPLEFORMAT, TIFF_SHORT, SAMPLEFORMAT_IEEEFP}};
  std::string file("II*\0\x08\0\0\0", 8);
  const auto append = [&](std::uint32_t number, std::size_t bytes) {
    file.append(reinterpret_cast<const char*>(&number), bytes);
  };
  append(std::uint32_t(fields.size()), 2);
  for (const auto& [tag, type, value] : fields) {
    append(tag, 2);
    append(type, 2);
    append(1, 4);
    append(value, 4);
  }
  append(0, 4);
  folder_.write("a.tif", file);
  EXPECT_EQ(error(), "page 1: the file is cut off: the pixels take 18446744073709551616 bytes, found 100");
}

TEST_F(TiffStack, AScanOfFibres) {
  const std::string path = BOXUNION_DATA "/100_fiberform.tif";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path << "; see BOXUNION_DATA";
  // The numbers of voxels, of faces between voxels inside and outside, and of components by
  // scipy.ndimage.label.
  const VolumeOptions options{.threshold = 90};
  const MassProperties mass = measure(read_boxes(path, nullptr, options), {.device = "native"});
  EXPECT_EQ(mass.volume, 167140);
  EXPECT_EQ(mass.area, 74392);
  EXPECT_EQ(mass.centroid, (std::array{73.3098599976068, 50.44667943041761, 49.16946272585856}));
  const Volume volume = read_volume(path, options);
  std::vector<std::uint32_t> labels(volume.inside.size());
  EXPECT_EQ(label_voxels(volume, Connectivity::faces, labels).size(), 10u);
  EXPECT_EQ(label_voxels(volume, Connectivity::points, labels).size(), 10u);
}

}  // namespace
}  // namespace boxunion

#endif

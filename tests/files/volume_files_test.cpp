#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/files.hpp"
#include "boxunion/union.hpp"
#include "boxunion/voxels.hpp"
#include "host/files/box_file.hpp"
#include "host/files/files.hpp"
#include "tests/files/volumes.hpp"
#include "tests/files/vox.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

using namespace std::string_literals;
using namespace scene;

/// A text compressed by zlib, in its own format or that of gzip.
std::string deflated(const std::string& plain, bool gzip) {
  z_stream zlib{};
  ::deflateInit2(&zlib, 6, Z_DEFLATED, gzip ? 31 : 15, 8, Z_DEFAULT_STRATEGY);
  std::string compressed(::deflateBound(&zlib, plain.size()) + 64, '\0');
  std::string input = plain;
  zlib.next_in = reinterpret_cast<Bytef*>(input.data());
  zlib.avail_in = uInt(input.size());
  zlib.next_out = reinterpret_cast<Bytef*>(compressed.data());
  zlib.avail_out = uInt(compressed.size());
  EXPECT_EQ(::deflate(&zlib, Z_FINISH), Z_STREAM_END);
  compressed.resize(zlib.total_out);
  ::deflateEnd(&zlib);
  return compressed;
}

class VolumeFile : public testing::Test {
 protected:
  std::vector<Box> read(const std::string& name, const std::string& content,
                        const VolumeOptions& options = {}) {
    const BoxSet set = read_boxes(folder_.write(name, content), nullptr, options);
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < set.size(); ++i) boxes.push_back(set[i]);
    is_integer_ = set.visit([]<class T>(const std::vector<BoxOf<T>>&) { return std::is_integral_v<T>; });
    return boxes;
  }
  /// The message of reading a file, without its folder, by read_boxes and by read_volume.
  std::string error(const std::string& name, const std::string& content, const VolumeOptions& options = {}) {
    const std::string path = folder_.write(name, content);
    const auto message = [&](auto read) {
      try {
        read();
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        std::string text = error.what();
        const std::string prefix = folder_.path() + "/";
        for (std::size_t at; (at = text.find(prefix)) != text.npos;) text.erase(at, prefix.size());
        return text;
      }
      return std::string();
    };
    const std::string found = message([&] { read_boxes(path, nullptr, options); });
    EXPECT_EQ(message([&] { read_volume(path, options); }), found);
    return found;
  }

  TemporaryFolder folder_;
  bool is_integer_ = false;
};

/// 3 x 2 x 2 voxels with values 0 .. 11, and which of them are inside.
template <class T>
std::vector<T> twelve() {
  std::vector<T> values;
  for (int i = 0; i < 12; ++i) values.push_back(T(i));
  return values;
}
const std::vector<Box> kNotZero = {{1, 0, 0, 3, 1, 1}, {0, 1, 0, 3, 2, 1}, {0, 0, 1, 3, 2, 2}};
const std::vector<Box> kFromEight = {{2, 0, 1, 3, 1, 2}, {0, 1, 1, 3, 2, 2}};

std::string npy(const std::string& descr, const std::string& shape, const std::string& data,
                const std::string& fortran_order = "False") {
  std::string header =
      "{'descr': '" + descr + "', 'fortran_order': " + fortran_order + ", 'shape': " + shape + ", }\n";
  return "\x93NUMPY\1\0"s + char(header.size()) + '\0' + header + data;
}

TEST_F(VolumeFile, NpyOfEveryTypeAndByteOrderIsRead) {
  const auto check = [&]<class T>(T, const std::string& type) {
    for (const bool swapped : {false, true}) {
      const std::string file = npy((swapped ? ">" : "<") + type, "(2, 2, 3)", bytes(twelve<T>(), swapped));
      EXPECT_EQ(read("a.npy", file), kNotZero) << type << swapped;
      EXPECT_TRUE(is_integer_);
      EXPECT_EQ(read("a.npy", file, {.threshold = 7.5}), kFromEight) << type << swapped;
      EXPECT_EQ(read("a.npy", file, {.threshold = 8}), kFromEight) << type << swapped;
      EXPECT_TRUE(read("a.npy", file, {.threshold = 1e30}).empty()) << type << swapped;
      EXPECT_EQ(read("a.npy", file, {.threshold = -1e30}), (std::vector<Box>{{0, 0, 0, 3, 2, 2}}))
          << type << swapped;
    }
  };
  check(std::uint8_t{}, "u1");
  check(std::int8_t{}, "i1");
  check(std::uint16_t{}, "u2");
  check(std::int16_t{}, "i2");
  check(std::uint32_t{}, "u4");
  check(std::int32_t{}, "i4");
  check(std::uint64_t{}, "u8");
  check(std::int64_t{}, "i8");
  check(float{}, "f4");
  check(double{}, "f8");
  EXPECT_EQ(read("a.npy", npy("|b1", "(2, 2, 3)", "\0\1\1\1\1\1\1\1\1\1\1\1"s)), kNotZero);
  EXPECT_EQ(read("a.npy", npy("|u1", "(2, 2, 3)", bytes(twelve<std::uint8_t>()))), kNotZero);
}

TEST_F(VolumeFile, ThresholdsAtTheEndsOfATypeAreExact) {
  const auto count = [&]<class T>(const std::string& type, const std::vector<T>& values, double threshold) {
    const auto boxes =
        read("a.npy", npy("<"s.append(type), "("s + std::to_string(values.size()) + ", 1, 1)", bytes(values)),
             {.threshold = threshold});
    double voxels = 0;
    for (const Box& box : boxes) voxels += box[5] - box[2];
    return voxels;
  };
  constexpr auto kMin = std::numeric_limits<std::int64_t>::min(),
                 kMax = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::int64_t> longs = {kMin, kMin + 1, -1, 0, kMax - 1, kMax};
  EXPECT_EQ(count("i8", longs, -0x1p63), 6);
  EXPECT_EQ(count("i8", longs, -0.5), 3);
  EXPECT_EQ(count("i8", longs, 0x1p63 - 1024), 2);
  EXPECT_EQ(count("i8", longs, 0x1p63), 0);
  EXPECT_EQ(count("u8", std::vector<std::uint64_t>{0, std::uint64_t(-1)}, 0x1p63), 1);
  EXPECT_EQ(count("u8", std::vector<std::uint64_t>{0, std::uint64_t(-1)}, 0x1p64), 0);
  EXPECT_EQ(count("u1", std::vector<std::uint8_t>{0, 254, 255}, 255), 1);
  EXPECT_EQ(count("u1", std::vector<std::uint8_t>{0, 254, 255}, 255.5), 0);
  EXPECT_EQ(count("u1", std::vector<std::uint8_t>{0, 254, 255}, -3), 3);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(count("f8", std::vector<double>{nan, -inf, 0.1, inf}, 0.1), 2);
}

TEST_F(VolumeFile, NanAndBothZerosAreOutside) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(read("a.npy", npy("<f8", "(5, 1, 1)", bytes<double>({nan, -0.0, 0.0, -1, 5e-324}))),
            (std::vector<Box>{{0, 0, 3, 1, 1, 5}}));
}

TEST_F(VolumeFile, NpyInFortranOrderIsTheSameVolume) {
  const Volume expected = random_volume(8);
  const auto [nx, ny, nz] = expected.grid.size;
  ASSERT_GT(nx * ny * nz, 300u);
  std::string data;
  for (std::size_t x = 0; x < nx; ++x)
    for (std::size_t y = 0; y < ny; ++y)
      for (std::size_t z = 0; z < nz; ++z) data += char(expected.inside[(z * ny + y) * nx + x]);
  const std::string shape =
      "("s + std::to_string(nz) + ", " + std::to_string(ny) + ", " + std::to_string(nx) + ")";
  const Volume c = read_volume(
      folder_.write("c.npy", npy("|u1", shape, std::string(expected.inside.begin(), expected.inside.end()))));
  const Volume fortran = read_volume(folder_.write("f.npy", npy("|u1", shape, data, "True")));
  EXPECT_EQ(c.inside.size(), expected.inside.size());
  EXPECT_TRUE(fortran.inside == c.inside);
  EXPECT_EQ(fortran.grid.size, expected.grid.size);
  EXPECT_EQ(measure(read_boxes(folder_.file("f.npy")), {.device = "native"}),
            measure(read_boxes(folder_.file("c.npy")), {.device = "native"}));
}

TEST_F(VolumeFile, BadNpyIsNamed) {
  EXPECT_EQ(error("a.npy", npy("<f2", "(1, 1, 1)", "00")),
            "a.npy: found voxels of type <f2, expected bool, integers of 8 to 64 bits, float32 (f4) or "
            "float64 (f8)");
  EXPECT_EQ(error("a.npy", npy("|u1", "(2, 2, 3)", "12345678901")),
            "a.npy: the file is cut off: the voxels take 12 bytes, found 11");
  EXPECT_EQ(error("a.npy", npy("|u1", "(2, 2, 3)", "1234567890123")),
            "a.npy: found 1 bytes after the 12 bytes of the voxels, expected none");
  EXPECT_EQ(error("a.npy", npy("|u1", "(2, 0, 3)", "")),
            "a.npy: found 3 x 0 x 2 voxels, expected 1 to 2147483647 along each axis");
  EXPECT_EQ(error("a.npy", npy("|u1", "(2147483648, 1, 1)", "")),
            "a.npy: found 1 x 1 x 2147483648 voxels, expected 1 to 2147483647 along each axis");
  EXPECT_EQ(error("a.npy", npy("<f8", "(2147483647, 2147483647, 1)", "")),
            "a.npy: found 1 x 2147483647 x 2147483647 voxels, expected fewer");
  EXPECT_EQ(error("a.npy", npy("<f8", "(2147483647, 200000000, 1)", "")),
            "a.npy: the file is cut off: the voxels take 3435973835200000000 bytes, found 0");
}

TEST_F(VolumeFile, OptionsOfVolumesAreRefusedForBoxes) {
  const auto usage = [&](const std::string& name, const std::string& content, const VolumeOptions& options) {
    try {
      read(name, content, options);
    } catch (const Error& error) {
      return error.kind() == ErrorKind::usage;
    }
    return false;
  };
  EXPECT_TRUE(usage("a.csv", "0,0,0,1,1,1\n", {.threshold = 1}));
  EXPECT_TRUE(usage("a.npy", npy("<f8", "(0, 6)", ""), {.threshold = 1}));
  EXPECT_TRUE(usage("a.npy", npy("|u1", "(1, 1, 1)", "1"), {.model = 1}));
  EXPECT_THROW(read_volume(folder_.write("a.csv", "0,0,0,1,1,1\n")), Error);
  EXPECT_THROW(read_volume(folder_.write("a.npy", npy("<f8", "(0, 6)", ""))), Error);
}

constexpr const char* kNrrd =
    "NRRD0004\n# a comment\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nencoding: raw\nkey:=value\n";

TEST_F(VolumeFile, NrrdIsReadAttachedAndDetachedRawAndGzip) {
  const std::string data = bytes(twelve<std::uint8_t>());
  EXPECT_EQ(read("a.nrrd", kNrrd + "\n"s + data), kNotZero);
  EXPECT_TRUE(is_integer_);
  const std::string head =
      "NRRD0005\r\ntype: unsigned short\r\ndimension: 3\r\nsizes: 3 2 2\r\nendian: big\r\n";
  const std::string shorts = bytes(twelve<std::uint16_t>(), true);
  EXPECT_EQ(read("a.nrrd", head + "encoding: gzip\r\n\r\n" + deflated(shorts, true)), kNotZero);
  EXPECT_EQ(read("a.nrrd", head + "encoding: gz\r\n\r\n" + deflated(shorts.substr(0, 7), true) +
                               deflated(shorts.substr(7), true)),
            kNotZero);
  folder_.write("a.raw", "line\nline\nxx" + shorts);
  EXPECT_EQ(read("a.nhdr", head + "encoding: raw\r\ndata file: a.raw\r\nline skip: 2\r\nbyte skip: 2\r\n",
                 {.threshold = 8}),
            kFromEight);
  EXPECT_EQ(read("a.nhdr", head + "encoding: raw\ndatafile: a.raw\nbyte skip: -1\n", {.threshold = 8}),
            kFromEight);
}

TEST_F(VolumeFile, NrrdLiesWhereItsFieldsSay) {
  const auto corner = [&](const std::string& fields) {
    const auto boxes = read(
        "a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n" + fields + "\n\0\1"s);
    EXPECT_EQ(boxes.size(), 1u);
    return boxes.at(0);
  };
  EXPECT_EQ(corner(""), (Box{1, 0, 0, 2, 1, 1}));
  EXPECT_EQ(corner("spacings: 0.5 2 3\n"), (Box{0.5, 0, 0, 1, 2, 3}));
  EXPECT_EQ(corner("spacings: 0.5 2 3\naxis mins: 10 20 30\ncenters: cell node cell\n"),
            (Box{10.5, 19, 30, 11, 21, 33}));
  EXPECT_EQ(corner("spacings: nan nan nan\n"), (Box{1, 0, 0, 2, 1, 1}));
  // with space directions, the origin is the centre of the first voxel
  const std::string space = "space dimension: 3\nspace origin: (10, 20, 30)\nspace directions: ";
  EXPECT_EQ(corner(space + "(2,0,0) (0,3,0) (0,0,4)\n"), (Box{11, 18.5, 28, 13, 21.5, 32}));
  EXPECT_EQ(corner(space + "(-2, 0, 0) (0, 3, 0) (0, 0, 4)\n"), (Box{7, 18.5, 28, 9, 21.5, 32}));
  EXPECT_EQ(corner(space + "(0,0,2) (4,0,0) (0,2,0)\n"), (Box{8, 19, 31, 12, 21, 33}));
  EXPECT_TRUE(is_integer_);
  EXPECT_EQ(corner("space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"),
            (Box{2, 0, 0, 4, 3, 4}));
}

TEST_F(VolumeFile, BadNrrdIsNamed) {
  const auto with = [&](const std::string& replaced, const std::string& by,
                        const std::string& data = "\n012345678901") {
    std::string header = kNrrd;
    header.replace(header.find(replaced), replaced.size(), by);
    return error("a.nrrd", header + data);
  };
  EXPECT_EQ(error("a.nrrd", ""),
            "a.nrrd: not an NRRD file, expected it to start with a line NRRD0001 to NRRD0005");
  EXPECT_EQ(with("NRRD0004", "NRRD9999"),
            "a.nrrd: not an NRRD file, expected it to start with a line NRRD0001 to NRRD0005");
  EXPECT_EQ(with("type: uchar\n", ""), "a.nrrd: the header has no type");
  EXPECT_EQ(with("uchar", "block"),
            "a.nrrd: found numbers of type block, expected integers of 8 to 64 bits, float or double");
  EXPECT_EQ(with("uchar", "float"), "a.nrrd: the header has no endian");
  EXPECT_EQ(with("dimension: 3", "dimension: 2"), "a.nrrd: dimension is 2, expected 3");
  EXPECT_EQ(with("3 2 2", "3 2"), "a.nrrd: sizes is \"3 2\", expected three whole numbers");
  EXPECT_EQ(with("3 2 2", "3 -2 2"), "a.nrrd: sizes is \"3 -2 2\", expected three whole numbers");
  EXPECT_EQ(with("3 2 2", "3 0 2"),
            "a.nrrd: found 3 x 0 x 2 voxels, expected 1 to 2147483647 along each axis");
  EXPECT_EQ(with("3 2 2", "3 99999999999 2"),
            "a.nrrd: found 3 x 99999999999 x 2 voxels, expected 1 to 2147483647 along each axis");
  EXPECT_EQ(with("raw", "hex"), "a.nrrd: found encoding hex, expected raw or gzip");
  EXPECT_EQ(with("# a comment", "no field"),
            "a.nrrd: the header has a line \"no field\", expected \"field: value\"");
  EXPECT_EQ(with("# a comment", "type: int8"), "a.nrrd: the header has type twice");
  EXPECT_EQ(with("# a comment", "spacings: 1 2"), "a.nrrd: spacings is \"1 2\", expected 3 finite numbers");
  EXPECT_EQ(with("# a comment", "spacings: 1 0 2"), "a.nrrd: spacings has a 0, expected other numbers");
  EXPECT_EQ(with("# a comment", "space directions: (1,0,0) (0,1,1) (0,0,1)"),
            "a.nrrd: space directions turns axis 2 to (0, 1, 1), expected axes along x, y and z: boxes "
            "cannot be oblique");
  EXPECT_EQ(with("# a comment", "space directions: (1,0,0) (2,0,0) (0,0,1)"),
            "a.nrrd: space directions turns axis 2 to (2, 0, 0), expected axes along x, y and z: boxes "
            "cannot be oblique");
  EXPECT_EQ(with("# a comment", "spacings: 1e308 1e308 1e308"),
            "a.nrrd: 3 voxels of 1e+308 from 0 on exceed the range of double");
  EXPECT_EQ(with("# a comment", "data file: none.raw"), "none.raw: cannot read: No such file or directory");
  EXPECT_EQ(with("# a comment", "data file: LIST"),
            "a.nrrd: data file is \"LIST\", expected the name of one file");
  EXPECT_EQ(with("# a comment", "byte skip: -2"), "a.nrrd: byte skip is -2, expected at least -1");
  EXPECT_EQ(with("# a comment", "#", "\n01234567890"),
            "a.nrrd: the file is cut off: the voxels take 12 bytes, found 11");
  EXPECT_EQ(with("# a comment", "#", "\n0123456789012"),
            "a.nrrd: found 1 bytes after the 12 bytes of the voxels, expected none");
  EXPECT_EQ(error("a.nrrd", "NRRD0004\n#" + std::string(2 << 20, 'x')),
            "a.nrrd: found no end of the header in 1048576 bytes");
}

TEST_F(VolumeFile, BrokenCompressionIsNamed) {
  const auto gzip = [&](const std::string& data, const std::string& sizes = "300 200 2") {
    return error("a.nrrd",
                 "NRRD0004\ntype: uchar\ndimension: 3\nsizes: " + sizes + "\nencoding: gzip\n\n" + data);
  };
  std::string plain;
  for (unsigned i = 0; i < 120'000; ++i) plain += char(i * i % 251);
  const std::string good = deflated(plain, true);
  EXPECT_EQ(gzip(good), "");
  EXPECT_EQ(gzip(good.substr(0, good.size() / 2)), "a.nrrd: the compressed voxels are cut off");
  EXPECT_EQ(gzip(good.substr(0, good.size() - 3)), "a.nrrd: the compressed voxels are cut off");
  EXPECT_EQ(gzip(deflated(plain.substr(1), true)), "a.nrrd: the compressed voxels end 1 bytes early");
  EXPECT_EQ(gzip(deflated(plain + "y", true)), "a.nrrd: found more compressed voxels than the header says");
  std::string wrong = good;
  wrong[wrong.size() - 6] = char(wrong[wrong.size() - 6] ^ 1);
  EXPECT_EQ(gzip(wrong), "a.nrrd: the compressed voxels are broken: incorrect data check");
  EXPECT_EQ(gzip("012345678901234567890123456789" + std::string(1000, 'x')),
            "a.nrrd: the compressed voxels are broken: incorrect header check");
  EXPECT_EQ(gzip(good, "2000000000 200000000 1"),
            "a.nrrd: the file is cut off: found " + std::to_string(good.size()) +
                " compressed bytes, too few for voxels of 400000000000000000 bytes");
}

constexpr const char* kMeta =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 3 2 2\nElementType = MET_UCHAR\n";

/// The boxes of a MetaImage, in which the centre of the first voxel, not its corner, is at the origin.
std::vector<Box> shifted(std::vector<Box> boxes) {
  for (Box& box : boxes)
    for (double& c : box) c -= 0.5;
  return boxes;
}

TEST_F(VolumeFile, MetaImageIsReadLocalAndBesideRawAndCompressed) {
  const std::string data = bytes(twelve<std::uint8_t>()), local = "ElementDataFile = LOCAL\n",
                    zlib = deflated(data, false);
  EXPECT_EQ(read("a.mha", kMeta + local + data), shifted(kNotZero));
  EXPECT_FALSE(is_integer_);
  EXPECT_EQ(read("a.mha", kMeta + "Offset = 0.5 0.5 0.5\n"s + local + data), kNotZero);
  EXPECT_TRUE(is_integer_);
  EXPECT_EQ(read("a.mha", kMeta + "CompressedData = True\n"s + local + zlib), shifted(kNotZero));
  EXPECT_EQ(read("a.mha", kMeta + "CompressedData = True\nCompressedDataSize = "s +
                              std::to_string(zlib.size()) + "\n" + local + zlib + "more"),
            shifted(kNotZero));
  folder_.write("a.raw", "head" + data);
  for (const char* size : {"4", "-1"})
    EXPECT_EQ(
        read("a.mhd", kMeta + "HeaderSize = "s + size + "\nElementDataFile = a.raw\n", {.threshold = 8}),
        shifted(kFromEight));
  folder_.write("a.zraw", zlib);
  EXPECT_EQ(read("a.mhd", kMeta + "CompressedData = True\nElementDataFile = a.zraw\n"s), shifted(kNotZero));
  std::string shorts = kMeta;
  shorts.replace(shorts.find("MET_UCHAR"), 9, "MET_SHORT");
  EXPECT_EQ(
      read("a.mha", shorts + "ElementByteOrderMSB = True\n" + local + bytes(twelve<std::int16_t>(), true),
           {.threshold = 8}),
      shifted(kFromEight));
}

TEST_F(VolumeFile, MetaImageLiesWhereItsFieldsSay) {
  const auto box = [&](const std::string& fields) {
    return read("a.mha", "NDims = 3\nDimSize = 2 1 1\nElementType = MET_UCHAR\n" + fields +
                             "ElementDataFile = LOCAL\n\0\1"s)
        .at(0);
  };
  EXPECT_EQ(box("ElementSpacing = 2 4 6\nOffset = 1 2 3\n"), (Box{2, 0, 0, 4, 4, 6}));
  EXPECT_EQ(box("ElementSpacing = 2 4 6\nPosition = 1 2 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n"),
            (Box{2, 0, 0, 4, 4, 6}));
  EXPECT_EQ(box("ElementSpacing = 2 4 6\nOrigin = 1 2 3\nTransformMatrix = 0 -1 0 0 0 1 1 0 0\n"),
            (Box{-2, -1, 1, 4, 1, 5}));
}

TEST_F(VolumeFile, BadMetaImageIsNamed) {
  const auto with = [&](const std::string& replaced, const std::string& by,
                        const std::string& end = "ElementDataFile = LOCAL\n012345678901") {
    std::string header = kMeta;
    header.replace(header.find(replaced), replaced.size(), by);
    return error("a.mha", header + end);
  };
  const std::string not_meta =
      "a.mha: not a MetaImage file, expected lines \"Field = value\" up to ElementDataFile";
  EXPECT_EQ(error("a.mha", ""), not_meta);
  EXPECT_EQ(error("a.mha", "\x89PNG\r\n\x1a\n = 1\n"), not_meta);
  EXPECT_EQ(with("Image", "Image", ""), not_meta);
  EXPECT_EQ(with("NDims = 3", "NDims = 2"), "a.mha: NDims is 2, expected 3");
  EXPECT_EQ(with("BinaryData = True", "BinaryData = False"), "a.mha: BinaryData is False, expected True");
  EXPECT_EQ(with("BinaryData = True", "BinaryData = perhaps"),
            "a.mha: BinaryData is \"perhaps\", expected True or False");
  EXPECT_EQ(with("BinaryData = True", "ElementNumberOfChannels = 3"),
            "a.mha: ElementNumberOfChannels is 3, expected 1");
  EXPECT_EQ(with("BinaryData = True", "TransformMatrix = 0.6 0.8 0 -0.8 0.6 0 0 0 1"),
            "a.mha: TransformMatrix turns axis 1 to (0.6, 0.8, 0), expected axes along x, y and z: boxes "
            "cannot be oblique");
  EXPECT_EQ(with("BinaryData = True", "ElementSpacing = 1 0 1"),
            "a.mha: ElementSpacing has a 0, expected other numbers");
  EXPECT_EQ(with("BinaryData = True", "Offset = a b c"),
            "a.mha: Offset is \"a b c\", expected 3 finite numbers");
  EXPECT_EQ(with("3 2 2", "0 2 2"),
            "a.mha: found 0 x 2 x 2 voxels, expected 1 to 2147483647 along each axis");
  EXPECT_EQ(
      with("MET_UCHAR", "MET_STRING"),
      "a.mha: found numbers of type MET_STRING, expected MET_CHAR, MET_UCHAR, MET_SHORT, ... or MET_DOUBLE");
  EXPECT_EQ(with("MET_UCHAR", "MET_DOUBLE"),
            "a.mha: the file is cut off: the voxels take 96 bytes, found 12");
  EXPECT_EQ(with("Image", "Image", "ElementDataFile = LIST\na.raw\n"),
            "a.mha: ElementDataFile is \"LIST\", expected LOCAL or the name of one file");
  EXPECT_EQ(
      with("Image", "Image", "CompressedData = True\nCompressedDataSize = 99\nElementDataFile = LOCAL\n0123"),
      "a.mha: the file is cut off: the header says 99 compressed bytes, found 4");
  EXPECT_EQ(with("Image", "Image", "ElementDataFile = LOCAL\n0123456789012"),
            "a.mha: found 1 bytes after the 12 bytes of the voxels, expected none");
}

const std::string kBar = model({4, 1, 1}, {{0, 0, 0, 5}, {1, 0, 0, 5}, {3, 0, 0, 9}});
const std::string kCube = model({3, 3, 3}, {{2, 1, 0, 1}});

TEST_F(VolumeFile, VoxModelsWithoutAGraphLieAtTheirOwnCoordinates) {
  EXPECT_EQ(read("a.vox", vox_file(chunk("PACK", bytes<std::uint32_t>({2})) + kBar + kCube +
                                   chunk("RGBA", "colours"))),
            (std::vector<Box>{{0, 0, 0, 2, 1, 1}, {3, 0, 0, 4, 1, 1}, {2, 1, 0, 3, 2, 1}}));
  EXPECT_TRUE(is_integer_);
  EXPECT_EQ(read("a.vox", vox_file(kBar + kCube), {.model = 2}), (std::vector<Box>{{2, 1, 0, 3, 2, 1}}));
  EXPECT_EQ(read("a.vox", vox_file(kBar), {.threshold = 6}), (std::vector<Box>{{3, 0, 0, 4, 1, 1}}));
}

TEST_F(VolumeFile, VoxModelsArePlacedByTheSceneGraph) {
  // A bar turned from +x to +y (rows (0,-1,0), (1,0,0), (0,0,1)) about its middle x = 2, then moved; and a
  // cube twice.
  const std::string quarter_turn = std::to_string(1 | 0 << 2 | 1 << 4);
  const std::string scene =
      vox_file(kBar + kCube + transform(0, 1, {}) + group(1, {2, 4, 6}) +
               transform(2, 3, {{"_r", quarter_turn}, {"_t", "10 20 30"}}) + shape(3, 0) +
               transform(4, 5, {{"_t", "-5 0 7"}}) + shape(5, 1) + transform(6, 7, {}) + shape(7, 1));
  EXPECT_EQ(
      read("a.vox", scene),
      (std::vector<Box>{
          {9, 18, 30, 10, 20, 31}, {9, 21, 30, 10, 22, 31}, {-4, 0, 6, -3, 1, 7}, {1, 0, -1, 2, 1, 0}}));
  // Rotations compose: the group turns by another quarter, so the bar points to -x.
  const std::string nested =
      vox_file(kBar + transform(0, 1, {{"_r", quarter_turn}, {"_t", "100 0 0"}}) + group(1, {2}) +
               transform(2, 3, {{"_r", quarter_turn}, {"_t", "10 0 0"}}) + shape(3, 0));
  EXPECT_EQ(read("a.vox", nested), (std::vector<Box>{{100, 9, 0, 102, 10, 1}, {98, 9, 0, 99, 10, 1}}));
  const Volume volume = read_volume(folder_.file("a.vox"));
  EXPECT_EQ(volume.grid.size, (std::array<std::size_t, 3>{4, 1, 1}));
  EXPECT_EQ(volume.grid.origin, (std::array<double, 3>{98, 9, 0}));
  EXPECT_EQ(std::vector<int>(volume.inside.begin(), volume.inside.end()), (std::vector<int>{1, 0, 1, 1}));
}

TEST_F(VolumeFile, VoxScenesGoToDiskWithABudget) {
  // two models of three boxes, repeated many times
  constexpr std::uint32_t kTimes = 1000;
  std::string nodes = transform(0, 1, {});
  std::vector<std::uint32_t> children;
  for (std::uint32_t i = 0; i < kTimes; ++i) {
    children.push_back(2 + 2 * i);
    nodes +=
        transform(2 + 2 * i, 3 + 2 * i, {{"_t", std::to_string(5 * i) + " 0 0"}}) + shape(3 + 2 * i, i % 2);
  }
  const std::string large = model({256, 256, 256}, {{0, 0, 0, 1}, {255, 255, 255, 1}});  // is nowhere
  const std::string path =
      folder_.write("a.vox", vox_file(kBar + kCube + large + nodes + group(1, children)));
  const BoxSet all = read_boxes(path);
  EXPECT_EQ(all.size(), 3 * kTimes / 2);
  const auto opened = [&](std::uint64_t mebibytes) {
    return open_boxes(path, Budget{mebibytes << 20, folder_.file("."), 0});
  };
  const std::unique_ptr<BoxFile> file = opened(130);
  ASSERT_EQ(file->size(), all.size());
  const BoxSet spooled = file->read(0, all.size());
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(spooled[i], all[i]);
  EXPECT_EQ(file->name_of(2), path + ": box 3");
  try {
    opened(90);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::resources);
    EXPECT_TRUE(std::string(e.what()).starts_with(path + ": the models of the scene may take ")) << e.what();
  }
}

TEST_F(VolumeFile, VoxGraphsOfManyChildrenOrEntriesTakeLittleMemory) {
  // a group with a million children that are all the same node, and frames with many meaningless entries
  const std::string many = group(1, std::vector<std::uint32_t>(1'000'000, 2));
  EXPECT_EQ(error("a.vox", vox_file(kBar + transform(0, 1, {}) + many + transform(2, 3, {}) + shape(3, 0))),
            "a.vox: the scene graph has node 2 twice, expected a tree");
  std::vector<std::pair<std::string, std::string>> entries(100'000, {"key", std::string(50, 'x')});
  entries.emplace_back("_t", "10 0 0");
  entries.emplace_back("_tt", std::string(100'000, '1'));
  EXPECT_EQ(read("a.vox", vox_file(kCube + transform(0, 1, entries) + shape(1, 0))),
            (std::vector<Box>{{11, 0, -1, 12, 1, 0}}));
}

/// The time for a model depends on the bounds of its voxels, not on the size that it claims. At 16 MB per
/// model this would take minutes.
TEST_F(VolumeFile, VoxModelsOfFewVoxelsAreRead) {
  constexpr int kModels = 30'000;
  std::string models;
  for (int i = 0; i < kModels; ++i)
    models += model({256, 256, 256}, {{std::uint8_t(i), 255, 7, 1}, {std::uint8_t(i), 254, 7, 1}});
  const auto start = std::chrono::steady_clock::now();
  const std::vector<Box> boxes = read("a.vox", vox_file(models));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  ASSERT_EQ(boxes.size(), std::size_t{kModels});
  for (int i = 0; i < kModels; ++i) {
    const double x = i % 256;
    ASSERT_EQ(boxes[std::size_t(i)], (Box{x, 254, 7, x + 1, 256, 8}));
  }
}

TEST_F(VolumeFile, BadVoxIsNamed) {
  EXPECT_EQ(error("a.vox", "PNG"), "a.vox: not a MagicaVoxel file, expected it to start with \"VOX \"");
  EXPECT_EQ(error("a.vox", "VOX \x09\0\0\0MAIN"s), "a.vox: found version 9, expected 150 or 200");
  EXPECT_EQ(error("a.vox", vox_file(kBar).substr(0, 60)),
            "a.vox: offset 20: found 40 bytes, expected 52 more: the file is cut off");
  EXPECT_EQ(error("a.vox", vox_file("")), "a.vox: found no model, expected chunks SIZE and XYZI");
  EXPECT_EQ(error("a.vox", vox_file(chunk("XYZI", ""))),
            "a.vox: offset 32: found a chunk XYZI, expected SIZE before it");
  EXPECT_EQ(error("a.vox", vox_file(chunk("SIZE", bytes<std::uint32_t>({1, 1, 1})))),
            "a.vox: offset 32: found a chunk SIZE without XYZI");
  EXPECT_EQ(error("a.vox", vox_file(model({1, 257, 1}, {}))),
            "a.vox: offset 32: found a model of 1 x 257 x 1 voxels, expected 1 to 256 along each axis");
  EXPECT_EQ(error("a.vox", vox_file(model({1, 0, 1}, {}))),
            "a.vox: offset 32: found a model of 1 x 0 x 1 voxels, expected 1 to 256 along each axis");
  EXPECT_EQ(error("a.vox", vox_file(model({1, 1, 1}, {{0, 0, 0, 1}, {0, 1, 0, 1}}))),
            "a.vox: offset 68: voxel 2 lies outside of its model");
  EXPECT_EQ(error("a.vox", vox_file(chunk("SIZE", bytes<std::uint32_t>({1, 1, 1})) +
                                    chunk("XYZI", bytes<std::uint32_t>({0x40000000})))),
            "a.vox: offset 60: found 0 bytes, expected 4294967296 more: the file is cut off");
  EXPECT_EQ(error("a.vox", vox_file(kBar + transform(0, 1, {}))), "a.vox: the scene graph has no node 1");
  EXPECT_EQ(error("a.vox", vox_file(kBar + transform(0, 0, {}))),
            "a.vox: the scene graph has node 0 twice, expected a tree");
  EXPECT_EQ(error("a.vox", vox_file(kBar + transform(0, 1, {}) + shape(1, 3))),
            "a.vox: node 1 has model 3, expected less than 1");
  EXPECT_NE(error("a.vox", vox_file(kBar + transform(0, 1, {{"_r", "5"}}) + shape(1, 0)))
                .find("_r is \"5\", expected a rotation"),
            std::string::npos);
  EXPECT_NE(error("a.vox", vox_file(kBar + transform(0, 1, {{"_t", "1 2"}}) + shape(1, 0)))
                .find("_t is \"1 2\", expected three whole numbers"),
            std::string::npos);
  EXPECT_EQ(error("a.vox", vox_file(kBar + transform(0, 1, {{"_t", "2147483647 0 0"}}) + shape(1, 0))),
            "a.vox: a voxel lies at 2147483649, expected coordinates of 32 bits");
  EXPECT_THROW(read("a.vox", vox_file(kBar), {.model = 2}), Error);
  EXPECT_NE(
      error("a.vox", vox_file(kBar + transform(0, 1, {{"_t", std::string(1'000'000, '1')}}) + shape(1, 0)))
          .find("_t is \"11111"),
      std::string::npos);
}

/// The file of a volume in the shared data. Skips the test if it is missing.
#define BOXUNION_DATA_FILE(path, name)             \
  const std::string path = BOXUNION_DATA "/" name; \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path << "; see BOXUNION_DATA"

TEST(KnownVolumes, AMagicaVoxelScene) {
  BOXUNION_DATA_FILE(path, "scene_store11.vox");
  EXPECT_EQ(measure(read_boxes(path), {.device = "native"}).volume, 430344);
}

}  // namespace
}  // namespace boxunion

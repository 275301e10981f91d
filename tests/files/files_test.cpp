#include "host/files/files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/interruptible.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

using namespace std::string_literals;

std::vector<Box> doubles(const BoxSet& boxes) {
  std::vector<Box> all;
  for (std::size_t i = 0; i < boxes.size(); ++i) all.push_back(boxes[i]);
  return all;
}

bool is_integer(const BoxSet& boxes) {
  return boxes.visit([]<class T>(const std::vector<BoxOf<T>>&) { return std::is_integral_v<T>; });
}

/// The message of reading a file, without its folder. Empty if the file can be read.
std::string read_error(const TemporaryFolder& folder, const std::string& name) {
  try {
    read_boxes(folder.file(name));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    const std::string message = error.what();
    const std::string prefix = folder.path() + "/";
    EXPECT_TRUE(message.starts_with(prefix)) << message;
    return message.substr(prefix.size());
  }
  return "";
}

class Csv : public testing::Test {
 protected:
  std::vector<Box> read(std::string_view text) { return doubles(read_boxes(folder_.write("a.csv", text))); }
  std::string error(std::string_view text) {
    folder_.write("a.csv", text);
    return read_error(folder_, "a.csv");
  }
  TemporaryFolder folder_;
};

TEST_F(Csv, HeaderCommentsBlanksSpacesAndLineEndsAreAllowed) {
  const std::vector<Box> expected = {{0, -1, 0.5, 1, 2, 3}, {1e300, 0, 0, 1e300, .5, 1}};
  EXPECT_EQ(read("0,-1,0.5,1,2,3\n1e300,0,0,1e300,.5,1\n"), expected);
  EXPECT_EQ(read("xmin,ymin,zmin,xmax,ymax,zmax\n0,-1,0.5,1,2,3\n1e300,0,0,1e300,.5,1"), expected);
  EXPECT_EQ(read("\xef\xbb\xbf# boxes\r\n\r\n XMin, yMin ,zmin,xmax,ymax,ZMAX\r\n"
                 " 0 ,\t-1,5e-1, +1 ,2.,3\r\n  # one more\r\n\r\n1E300,-0,0,1e+300,0.5,1 \r\n\n"),
            expected);
}

TEST_F(Csv, NumbersAreRoundedToTheNearestDouble) {
  EXPECT_EQ(
      read("0.1,9007199254740993,1e-400,0.30000000000000004,1.7976931348623157e308,5e-324\n"),
      (std::vector<Box>{{0.1, 9007199254740992, 0, 0.30000000000000004, 1.7976931348623157e308, 5e-324}}));
}

TEST_F(Csv, HeaderOnlyIsNoBoxes) {
  EXPECT_TRUE(read("xmin,ymin,zmin,xmax,ymax,zmax").empty());
}

TEST_F(Csv, EmptyFilesAreErrors) {
  EXPECT_EQ(
      error(""),
      "a.csv: no boxes: the file is empty; expected the header xmin,ymin,zmin,xmax,ymax,zmax or lines of "
      "six numbers");
  EXPECT_EQ(error("\n# nothing\n"),
            "a.csv: no boxes: the file has only blank lines and comments; expected the header "
            "xmin,ymin,zmin,xmax,ymax,zmax or lines of six numbers");
}

TEST_F(Csv, BadRowsAreNamed) {
  EXPECT_EQ(error("xmin,ymin,zmin,xmax,ymax,zmax\n\n0,0,0,1,1\n"),
            "a.csv:3: found 5 columns, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  EXPECT_EQ(error("0,0,0,1,1,1,\n"), "a.csv:1: found 7 columns, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  EXPECT_EQ(error("0 0 0 1 1 1\n"), "a.csv:1: found 1 column, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  EXPECT_EQ(error("0,0,0,1,1,1\n0,zero,0,1,1,1\n"), "a.csv:2: ymin is \"zero\", expected a number");
  EXPECT_EQ(error("0,0,0,1,1,1\n0,0,0,1 2,1,1\n"), "a.csv:2: xmax is \"1 2\", expected a number");
  EXPECT_EQ(error("0,0,,1,1,1"), "a.csv:1: zmin is \"\", expected a number");
  EXPECT_EQ(error("0,0,0x10,1,1,1"), "a.csv:1: zmin is \"0x10\", expected a number");
  EXPECT_EQ(error("0,0,+-1,1,1,1"), "a.csv:1: zmin is \"+-1\", expected a number");
  EXPECT_EQ(error("0,0,\"1\",1,1,1"), "a.csv:1: zmin is \"\"1\"\", expected a number");
  EXPECT_EQ(error("0,0,0,1,nan,1\r\n"), "a.csv:1: ymax is nan, expected a finite number");
  EXPECT_EQ(error("0,0,0,1,1,Inf"), "a.csv:1: zmax is inf, expected a finite number");
  EXPECT_EQ(error("-1e999,0,0,1,1,1"), "a.csv:1: xmin is \"-1e999\", beyond the range of double");
  EXPECT_EQ(error("0,0,5,1,1,4.5"), "a.csv:1: zmin is 5 and zmax is 4.5, expected zmin <= zmax");
  EXPECT_EQ(error("xmin,ymin,zmin,xmax,ymax,zmax\nxmin,ymin,zmin,xmax,ymax,zmax\n"),
            "a.csv:2: xmin is \"xmin\", expected a number");
  EXPECT_EQ(error("\x93NUMPY\x01\x00v\x00"s),
            "a.csv:1: found 1 column, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  EXPECT_EQ(error("a\tb\x1b[2J,0,0,1,1," + std::string(60, 'x')),
            "a.csv:1: xmin is \"a?b?[2J\", expected a number");
}

TEST_F(Csv, TheFirstBadLineOfALongFileIsNamed) {
  std::string text = "# many\n";
  for (int i = 0; i < 200'000; ++i) text += "0.125,0.25,0,1,1,1\n";
  text += "0,0,0,1,1,bad\n";
  for (int i = 0; i < 200'000; ++i) text += "0.125,0.25,0,1,1,worse\n";
  EXPECT_EQ(error(text), "a.csv:200002: zmax is \"bad\", expected a number");
}

TEST_F(Csv, LongFilesKeepTheirOrder) {
  std::string text;
  for (int i = 0; i < 300'000; ++i) text += std::to_string(i) + ",0,0,300000,1,1" + (i % 2 ? "\r\n" : "\n");
  const std::vector<Box> boxes = read(text);
  ASSERT_EQ(boxes.size(), 300'000u);
  for (std::size_t i = 0; i < boxes.size(); ++i) ASSERT_EQ(boxes[i][0], double(i));
}

TEST_F(Csv, CommentsMayBeLongerThanABlock) {
  const std::string comment = "#" + std::string(3 << 20, 'x') + "\n";
  EXPECT_EQ(read(comment + "0,0,0,1,1,1\n" + comment + "1,0,0,2,1,1"),
            (std::vector<Box>{{0, 0, 0, 1, 1, 1}, {1, 0, 0, 2, 1, 1}}));
}

TEST_F(Csv, ALineWithoutEndIsAnError) {
  EXPECT_EQ(error("0,0,0,1,1,1\n" + std::string(40 << 20, '7')),
            "a.csv:2: the line is longer than 8388608 bytes, expected six numbers");
}

/// An NPY file with the given header fields.
std::string npy(const std::string& descr, const std::string& shape, const std::string& data,
                const std::string& fortran_order = "False", int version = 1) {
  std::string header =
      "{'descr': " + descr + ", 'fortran_order': " + fortran_order + ", 'shape': " + shape + ", }\n";
  std::string file = "\x93NUMPY"s + char(version) + '\0' + char(header.size()) + '\0';
  if (version > 1) file += "\0\0"s;
  return file + header + data;
}

class Npy : public testing::Test {
 protected:
  BoxSet read(std::string_view content) { return read_boxes(folder_.write("a.npy", content)); }
  std::string error(std::string_view content) {
    folder_.write("a.npy", content);
    return read_error(folder_, "a.npy");
  }
  TemporaryFolder folder_;
};

const std::vector<Box> kTwo = {{0, 1, 2, 3, 4, 5}, {6, 7, 8, 9, 10, 11}};

template <class T>
std::vector<T> two(bool fortran_order = false) {
  std::vector<T> values;
  for (int i = 0; i < 12; ++i) values.push_back(T(fortran_order ? i % 2 * 6 + i / 2 : i));
  return values;
}

TEST_F(Npy, AllTypesOrdersAndVersionsAreRead) {
  const auto check = [&]<class T>(T, const std::string& type) {
    for (const bool swapped : {false, true})
      for (const bool fortran_order : {false, true})
        for (const int version : {1, 2, 3}) {
          const BoxSet boxes =
              read(npy((swapped ? "'>" : "'<") + type + "'", "(2, 6)", bytes(two<T>(fortran_order), swapped),
                       fortran_order ? "True" : "False", version));
          EXPECT_EQ(doubles(boxes), kTwo) << type << swapped << fortran_order << version;
          EXPECT_EQ(is_integer(boxes), type == "i4");
        }
  };
  check(double{}, "f8");
  check(float{}, "f4");
  check(std::int32_t{}, "i4");
  check(std::int64_t{}, "i8");
}

TEST_F(Npy, LongArraysOfEveryLayoutAgree) {
  constexpr int kRows = 150'001;
  std::vector<double> rows, columns(6 * kRows);
  for (int i = 0; i < 6 * kRows; ++i) rows.push_back(i);
  for (std::size_t r = 0; r < kRows; ++r)
    for (std::size_t c = 0; c < 6; ++c) columns[c * kRows + r] = rows[6 * r + c];
  const auto expected = doubles(read(npy("'<f8'", "(150001, 6)", bytes(rows))));
  EXPECT_EQ(expected.back()[5], 6.0 * kRows - 1);
  EXPECT_EQ(doubles(read(npy("'<f8'", "(150001, 6)", bytes(columns), "True"))), expected);
  EXPECT_EQ(doubles(read(npy("'>f8'", "(150001, 6)", bytes(rows, true)))), expected);
}

TEST_F(Npy, NoRowsIsNoBoxes) {
  EXPECT_EQ(read(npy("'<f8'", "(0, 6)", "")).size(), 0u);
}

TEST_F(Npy, WrongTypesAndShapesAreNamed) {
  const std::string types = ", expected float64 (f8), float32 (f4), int32 (i4) or int64 (i8)";
  EXPECT_EQ(error(npy("'<u4'", "(1, 6)", "")), "a.npy: found numbers of type <u4" + types);
  EXPECT_EQ(error(npy("'|O'", "(1, 6)", "")), "a.npy: found numbers of type |O" + types);
  EXPECT_EQ(error(npy("[('x', '<f8'), ('y', '<f8', (2,))]", "(1, 6)", "")),
            "a.npy: found numbers of type [('x', '<f8'), ('y', '<f8', (2,))]" + types);
  EXPECT_EQ(error(npy("'<f8'", "(2, 3)", "")),
            "a.npy: found an array of shape (2, 3), expected (n, 6), or (z, y, x) for voxels");
  EXPECT_EQ(error(npy("'<f8'", "(6,)", "")),
            "a.npy: found an array of shape (6,), expected (n, 6), or (z, y, x) for voxels");
  EXPECT_EQ(error(npy("'<f8'", "()", "")),
            "a.npy: found an array of shape (), expected (n, 6), or (z, y, x) for voxels");
  EXPECT_EQ(error(npy("'<f8'", "(1, 6, 1, 1)", "")),
            "a.npy: found an array of shape (1, 6, 1, 1), expected (n, 6), or (z, y, x) for voxels");
  EXPECT_EQ(error(npy("'<f8'", "(-1, 6)", "")),
            "a.npy: found an array of shape (-1, 6), expected (n, 6), or (z, y, x) for voxels");
  EXPECT_EQ(error(npy("'<f8'", "(99999999999999999999999, 6)", "")),
            "a.npy: found an array of shape (99999999999999999999999, 6), expected (n, 6), or (z, y, x) for "
            "voxels");
}

TEST_F(Npy, BrokenFilesAreErrors) {
  EXPECT_EQ(error(""), "a.npy: no boxes: the file is empty; expected an NPY array of shape (n, 6)");
  EXPECT_EQ(error("0,0,0,1,1,1\n"), "a.npy: not an NPY file, expected it to start with \\x93NUMPY");
  EXPECT_EQ(error("\x93NUM"), "a.npy: not an NPY file, expected it to start with \\x93NUMPY");
  EXPECT_EQ(error(npy("'<f8'", "(0, 6)", "", "False", 9)),
            "a.npy: found NPY version 9.0, expected 1, 2 or 3");
  EXPECT_EQ(error(npy("'<f8'", "(0, 6)", "").substr(0, 30)),
            "a.npy: the file is cut off: found 30 bytes, expected a header of 70");
  EXPECT_EQ(error(npy("'<f8'", "(0, 6)", "", "Maybe")),
            "a.npy: the NPY header is broken, expected descr, fortran_order (True or False) and shape");
  EXPECT_EQ(error("\x93NUMPY\x01\x00\x04\x00????"s),
            "a.npy: the NPY header is broken, expected descr, fortran_order (True or False) and shape");
}

TEST_F(Npy, AHeaderThatClaimsMoreThanTheFileHoldsAllocatesNothing) {
  EXPECT_EQ(error(npy("'<f8'", "(2, 6)", bytes(two<double>()).substr(0, 95))),
            "a.npy: the file is cut off: the header says 2 rows, found the bytes of 1");
  EXPECT_EQ(error(npy("'<i4'", "(1000000000000000000, 6)", bytes(two<std::int32_t>()))),
            "a.npy: the file is cut off: the header says 1000000000000000000 rows, found the bytes of 2");
  EXPECT_EQ(error(npy("'<f8'", "(1, 6)", bytes(two<double>()))),
            "a.npy: found 48 bytes after the 1 rows of the header, expected none");
}

TEST_F(Npy, InvalidRowsAreNamed) {
  auto values = two<double>();
  values[8] = std::nan("");
  EXPECT_EQ(error(npy("'<f8'", "(2, 6)", bytes(values))),
            "a.npy: row 2: zmin is nan, expected a finite number");
  auto singles = two<float>();
  singles[3] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(error(npy("'<f4'", "(2, 6)", bytes(singles))),
            "a.npy: row 1: xmax is inf, expected a finite number");
  auto integers = two<std::int32_t>();
  integers[6] = 100;
  EXPECT_EQ(error(npy("'<i4'", "(2, 6)", bytes(integers))),
            "a.npy: row 2: xmin is 100 and xmax is 9, expected xmin <= xmax");
}

TEST_F(Npy, OnlyIntegersThatDoublesEqualAreRead) {
  auto values = two<std::int64_t>();
  values[0] = std::numeric_limits<std::int64_t>::min();
  values[9] = (std::int64_t{1} << 53) + 2;
  EXPECT_EQ(doubles(read(npy("'<i8'", "(2, 6)", bytes(values))))[1][3], 9007199254740994.0);
  values[9] = (std::int64_t{1} << 53) + 1;
  EXPECT_EQ(error(npy("'<i8'", "(2, 6)", bytes(values))),
            "a.npy: row 2: no double equals 9007199254740993, expected at most 53 significant bits");
  values[9] = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(error(npy("'<i8'", "(2, 6)", bytes(values))),
            "a.npy: row 2: no double equals 9223372036854775807, expected at most 53 significant bits");
}

TEST(Files, UnreadableFilesAreErrors) {
  const std::string kInputs = ".csv, .npy, .nrrd, .nhdr, .mha, .mhd, .tif, .tiff or .vox";
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("folder.csv"));
  folder.write("a.txt", "0,0,0,1,1,1");
  EXPECT_EQ(read_error(folder, "none.csv"), "none.csv: cannot read: No such file or directory");
  EXPECT_EQ(read_error(folder, "none.npy"), "none.npy: cannot read: No such file or directory");
  EXPECT_EQ(read_error(folder, "folder.csv"), "folder.csv: cannot read: Is a directory");
  EXPECT_EQ(read_error(folder, "a.txt"), "a.txt: unknown extension .txt, expected "s + kInputs);
  EXPECT_EQ(read_error(folder, "a"), "a: no file extension, expected "s + kInputs);
}

TEST(Files, BoxesSurviveWritingAndReading) {
  const TemporaryFolder folder;
  std::mt19937_64 random(5);
  std::vector<Box> boxes;
  while (boxes.size() < 20'000) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double a = std::bit_cast<double>(random()), b = std::bit_cast<double>(random());
      box[axis] = std::min(a, b);
      box[axis + 3] = std::max(a, b);
    }
    if (is_valid(box)) boxes.push_back(box);
  }
  const std::vector<IntegerBox> integers = {{-2147483647 - 1, 0, 0, 2147483647, 0, 0}, {0, 1, 2, 3, 4, 5}};
  for (const char* name : {"a.csv", "a.npy", "a.NPY"}) {
    write_boxes(boxes, open_output(folder.file(name)));
    EXPECT_EQ(doubles(read_boxes(folder.file(name))), boxes) << name;
    write_boxes(integers, open_output(folder.file(name)));
    EXPECT_EQ(doubles(read_boxes(folder.file(name))), doubles(integers)) << name;
    EXPECT_EQ(is_integer(read_boxes(folder.file(name))), std::string(name) != "a.csv");
  }
  EXPECT_EQ(folder.read("a.csv"),
            "xmin,ymin,zmin,xmax,ymax,zmax\n-2147483648,0,0,2147483647,0,0\n0,1,2,3,4,5\n");
}

TEST(Files, VerticesAreWrittenWithTheirDegrees) {
  const TemporaryFolder folder;
  Solid solid;
  solid.axes = {Axis::rank({-1.5, 0.1}), Axis::lattice(-1, 0, 2), Axis::lattice(-1, -1, 2)};
  solid.vertices = {{1, 1, 1, 128}, {2, 2, 2, 0b01101001}};
  write_vertices(solid, open_output(folder.file("v.csv")));
  EXPECT_EQ(folder.read("v.csv"),
            "x,y,z,mask,degree_px,degree_nx,degree_py,degree_ny,degree_pz,degree_nz\n"
            "-1.5,0,0,128,0,1,0,1,0,1\n0.1,1,0.5,105,2,2,2,2,2,2\n");

  write_vertices(solid, open_output(folder.file("v.npy")));
  const std::string array = folder.read("v.npy");
  ASSERT_EQ(array.size(), 192u + 2 * 31);
  EXPECT_EQ(array.substr(192, 31), bytes<double>({-1.5, 0, 0}) + "\x80\0\1\0\1\0\1"s);
  EXPECT_EQ(array.substr(223), bytes<double>({0.1, 1, 0.5}) + "\x69\2\2\2\2\2\2"s);
}

TEST(OutputFile, AppearsOnlyWhenItIsComplete) {
  const TemporaryFolder folder;
  folder.write("a.csv", "old");
  {
    OutputFile file(folder.file("a.csv"));
    file.write(std::string(3 << 20, 'x'));
    EXPECT_EQ(folder.read("a.csv"), "old");
  }
  EXPECT_EQ(folder.read("a.csv"), "old");
  EXPECT_EQ(folder.file_count(), 1u);
  OutputFile file(folder.file("a.csv"));
  file.write("new");
  file.commit();
  EXPECT_EQ(folder.read("a.csv"), "new");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(OutputFile, FollowsALinkToAFile) {
  const TemporaryFolder folder;
  folder.write("real.csv", "old");
  std::filesystem::create_symlink("real.csv", folder.file("link.csv"));
  OutputFile file(folder.file("link.csv"));
  file.write("new");
  file.commit();
  EXPECT_EQ(folder.read("real.csv"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("link.csv")));
}

TEST(OutputFile, StopsWhenInterrupted) {
  const TemporaryFolder folder;
  std::atomic<bool> interrupted = false;
  OutputFile file(folder.file("a.csv"));
  {
    const Interruptible scope(&interrupted);
    file.write("x");
    interrupted = true;
    EXPECT_THROW(file.write("y"), Error);
  }
  EXPECT_THROW(read_boxes(folder.write("b.csv", "0,0,0,1,1,1"), &interrupted), Error);
}

TEST(OutputFile, PlacesThatCannotBeWrittenAreErrors) {
  const TemporaryFolder folder;
  folder.write("file", "");
  std::filesystem::create_directory(folder.file("folder.csv"));
  const auto error = [&](const std::string& path) {
    try {
      OutputFile file(path);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string none = folder.file("none"), file = folder.file("file");
  EXPECT_EQ(error(none + "/a.csv"), none + "/a.csv: cannot create the file: " + none + " does not exist");
  EXPECT_EQ(error(file + "/a.csv"), file + "/a.csv: cannot create the file: " + file + " is not a folder");
  EXPECT_EQ(error(folder.file("folder.csv")),
            folder.file("folder.csv") + ": cannot create the file: it is a folder");
  EXPECT_EQ(error("/dev/null"), "/dev/null: cannot create the file: it exists and is not a regular file");
  EXPECT_EQ(error("/proc/a.csv"), "/proc/a.csv: cannot create the file: No such file or directory");
}

}  // namespace
}  // namespace boxunion

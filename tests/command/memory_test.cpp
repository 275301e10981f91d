// The process keeps to --memory, whatever the input: its peak, as reported by the system, stays within the
// budget, or it ends with an error that says why.

#include <zlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "host/files/files.hpp"
#include "tests/command/command.hpp"
#include "tests/files/vox.hpp"

namespace boxunion {
namespace {

using namespace scene;
using namespace std::string_literals;

constexpr std::uint64_t kLarge = 600'000'000;  // bytes that a hostile file has or claims

/// A NPY file of version 2 with a header of `length` bytes.
std::string npy_start(std::uint32_t length) {
  return "\x93NUMPY\2\0"s + bytes<std::uint32_t>({length});
}
std::string npy(const std::string& descr, const std::string& shape) {
  const std::string header = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': " + shape + ", }\n";
  return npy_start(std::uint32_t(header.size())) + header;
}

/// `count` zeros, compressed by gzip.
std::string gzip_zeros(std::uint64_t count) {
  z_stream zlib{};
  ::deflateInit2(&zlib, 1, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY);
  std::string zeros(1 << 20, '\0'), out(1 << 16, '\0'), all;
  do {
    zlib.next_in = reinterpret_cast<Bytef*>(zeros.data());
    zlib.avail_in = uInt(std::min<std::uint64_t>(count, zeros.size()));
    count -= zlib.avail_in;
    do {
      zlib.next_out = reinterpret_cast<Bytef*>(out.data());
      zlib.avail_out = uInt(out.size());
      ::deflate(&zlib, count == 0 ? Z_FINISH : Z_NO_FLUSH);
      all.append(out.data(), out.size() - zlib.avail_out);
    } while (zlib.avail_out == 0);
  } while (count > 0);
  ::deflateEnd(&zlib);
  return all;
}

/// A TIFF file of one page. Its voxels are one strip at byte 1000, and its description is at the same place.
std::string tiff(std::uint32_t width, std::uint32_t height, std::uint32_t description_bytes) {
  struct Tag {
    std::uint16_t id, type;
    std::uint32_t count, value;
  };
  const std::vector<Tag> tags = {{256, 4, 1, width},  {257, 4, 1, height},
                                 {258, 3, 1, 8},      {259, 3, 1, 1},
                                 {262, 3, 1, 1},      {270, 2, description_bytes, 1000},
                                 {273, 4, 1, 1000},   {277, 3, 1, 1},
                                 {278, 4, 1, height}, {279, 4, 1, width * height}};
  std::string file = "II" + bytes<std::uint16_t>({42}) + bytes<std::uint32_t>({8}) +
                     bytes<std::uint16_t>({std::uint16_t(tags.size())});
  for (const Tag& tag : tags)
    file += bytes<std::uint16_t>({tag.id, tag.type}) + bytes<std::uint32_t>({tag.count, tag.value});
  return file + bytes<std::uint32_t>({0});
}

/// Every other voxel of a cube of edge `edge`, at `times` places of a scene.
std::string checkerboards(std::uint8_t edge, std::uint32_t times) {
  std::vector<std::array<std::uint8_t, 4>> voxels;
  for (std::uint8_t z = 0; z < edge; ++z)
    for (std::uint8_t y = 0; y < edge; ++y)
      for (std::uint8_t x = std::uint8_t((y + z) % 2); x < edge; x = std::uint8_t(x + 2))
        voxels.push_back({x, y, z, 1});
  std::string nodes = transform(0, 1, {});
  std::vector<std::uint32_t> children;
  for (std::uint32_t i = 0; i < times; ++i) {
    children.push_back(2 + 2 * i);
    nodes +=
        transform(2 + 2 * i, 3 + 2 * i, {{"_t", std::to_string(300 * i) + " 0 0"}}) + shape(3 + 2 * i, 0);
  }
  return vox_file(model({edge, edge, edge}, voxels) + nodes + group(1, children));
}

class MemoryBudget : public Command {
 protected:
  void SetUp() override {
    if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any budget";
  }

  /// Runs a command. Expects that it keeps to the budget and, if it fails, says why in one line.
  Outcome run_within(const std::string& command, unsigned mebibytes) {
    const std::string arguments =
        command + " --quiet --device native --memory " + std::to_string(mebibytes) + "M";
    const Outcome r = shell("boxunion_peak .peak boxunion " + arguments);
    const std::uint64_t peak = std::stoull(folder_.read(".peak"));
    EXPECT_LE(peak, std::uint64_t{mebibytes} << 10) << arguments << r.err;
    EXPECT_GT(peak, 1000u);
    EXPECT_TRUE(r.status == 0 || r.status == 3 || r.status == 5) << arguments << ": " << r.status << r.err;
    if (r.status != 0) {
      EXPECT_TRUE(r.err.starts_with("boxunion: error: ")) << r.err;
      EXPECT_EQ(std::ranges::count(r.err, '\n'), 1) << r.err;
      EXPECT_LT(r.err.size(), 400u);
    }
    return r;
  }

  /// Writes a file that begins with `start` and continues with zeros, which take no disk space.
  void write_sparse(const std::string& name, const std::string& start, std::uint64_t size) {
    std::filesystem::resize_file(folder_.write(name, start), size);
  }
};

struct Hostile {
  std::string name, start;
  std::uint64_t size;   ///< 0: the size of the start
  std::string message;  ///< a part of the message
};

std::vector<Hostile> hostile_files() {
  const std::string nrrd = "NRRD0004\ntype: uchar\ndimension: 3\n";
  return {
      {"commas.csv", std::string(7'000'000, ','), 0, "commas.csv:1: found 7000001 columns, expected 6"},
      {"line.csv", "0,0,0,1,1,1\n" + std::string(33'000'000, ','), 0, "line.csv:2: the line is longer than"},
      {"zeros.csv", "0,0,0,1,1,1\n", kLarge, "zeros.csv:2: the line is longer than"},
      {"header.npy", npy_start(kLarge), kLarge + 12, "found a header of 600000000 bytes, expected at most"},
      {"claim.npy", npy_start(0xffffffff), 0, "the file is cut off"},
      {"shape.npy", npy("<f8", "(" + std::string(900'000, '1') + ")"), 0, "found an array of shape (111"},
      {"rows.npy", npy("<f8", "(2000000000, 6)"), 1000, "the file is cut off"},
      {"line.nrrd", nrrd, kLarge, "found no end of the header"},
      {"field.nrrd", nrrd + std::string(900'000, 'x') + "\n", 0, "the header has a line \"xxx"},
      {"skip.nrrd", nrrd + "sizes: 1 1 1\nencoding: raw\nline skip: 1000000000\n\n", kLarge,
       "the file is cut off"},
      {"many.mha",
       [] {
         std::string fields;
         for (int i = 0; i < 300'000; ++i) fields += "F" + std::to_string(i) + "=\n";
         return fields;
       }(),
       0, "found no end of the header"},
      {"line.mha", "NDims = ", kLarge, "found no end of the header"},
      {"tags.tif", tiff(10, 10, kLarge), kLarge + 1000, "the tags of a page take more than"},
      {"text.vox", vox_file(chunk("nTRN", bytes<std::uint32_t>({0, 0xffffffff}))), 0, "the file is cut off"},
      {"children.vox", checkerboards(2, 1) + std::string(100, 'x'), 0, ""},
  };
}

TEST_F(MemoryBudget, HostileFilesAreErrorsOfLittleMemory) {
  for (const Hostile& file : hostile_files()) {
    SCOPED_TRACE(file.name);
    folder_.write(file.name, file.start);
    if (file.size > 0) write_sparse(file.name, file.start, file.size);
    for (const std::string command : {"measure ", "decompose ", "label ", "combine A A="})
      run_within(command + file.name, 128);
    const Outcome r = run_within("boundary -o v.npy " + file.name, 512);
    if (!file.message.empty()) {
      EXPECT_EQ(r.status, 3);
      EXPECT_NE(r.err.find(file.message), std::string::npos) << r.err;
    }
    std::filesystem::remove(folder_.file(file.name));
  }
}

/// Valid files that have, or expand to, more than the budget.
TEST_F(MemoryBudget, LargeFilesFitOrSayHowMuchTheyNeed) {
  const std::string nrrd = "NRRD0004\ntype: uchar\ndimension: 3\nencoding: gzip\nsizes: ";
  folder_.write("slice.nrrd", nrrd + "600000000 1 1\n\n" + gzip_zeros(kLarge));
  folder_.write("slices.nrrd", nrrd + "1000 1000 600\n\n" + gzip_zeros(kLarge));
  write_sparse("rows.npy", npy("<f4", "(25000000, 6)"), npy("<f4", "(25000000, 6)").size() + kLarge);
  write_sparse("wide.tif", tiff(24'000, 25'000, 5), kLarge + 1000);
  folder_.write("scene.vox", checkerboards(20, 200));
  for (const std::string name : {"slice.nrrd", "slices.nrrd", "rows.npy", "wide.tif", "scene.vox"})
    for (const unsigned mebibytes : {128u, 512u}) {
      SCOPED_TRACE(name);
      const auto expect = [&](const std::string& command, bool fits) {
        const Outcome r = run_within(command, mebibytes);
        EXPECT_EQ(r.status, fits ? 0 : 5) << command << r.err;
        if (r.status == 5) {
          EXPECT_TRUE(r.err.find("MiB") != r.err.npos || r.err.find(" bytes") != r.err.npos) << r.err;
        }
      };
      const bool is_streamed = name == "slices.nrrd" || name == "rows.npy" || name == "scene.vox";
      expect("measure " + name, is_streamed);
      expect("decompose " + name, is_streamed);
      if (name == "slices.nrrd" || name == "scene.vox") expect("combine A A=" + name, true);
      expect("label " + name, name == "scene.vox" && mebibytes == 512);
    }
}

TEST_F(MemoryBudget, OrdinaryRunsKeepToIt) {
  run("generate boxes --count 250000 --max-edge 200 -o a.npy --quiet");
  run("generate boxes --count 100000 --max-edge 90 --seed 2 -o b.csv --quiet");
  run("generate porous --size 150 --volume -o v.npy --quiet");
  for (const unsigned mebibytes : {128u, 512u})
    for (const std::string input : {"a.npy", "b.csv", "v.npy"})
      for (const std::string command :
           {"measure ", "measure --method cells --threads 1 ", "boundary -o v.ply ", "decompose -o d.csv ",
            "decompose --connectivity 26 ", "label ", "label -o l.npy ", "combine -o c.stl A A="}) {
        const Outcome r = run_within(command + input, mebibytes);
        const bool is_held = command.starts_with("label") || command.starts_with("combine");
        EXPECT_TRUE(r.status == 0 || (is_held && mebibytes == 128 && r.status == 5))
            << command << input << r.err;
      }
}

TEST_F(MemoryBudget, LabelAndCombineGiveTheSameResultsWithinIt) {
  run("generate boxes --count 20000 --max-edge 200 -o a.npy --quiet");
  run("generate boxes --count 20000 --max-edge 200 --seed 2 -o b.csv --quiet");
  for (const std::string task : {"label a.npy --components c.csv -o out.npy", "label b.csv -o out.npy",
                                 "combine \"A not B\" A=a.npy B=b.csv -o out.npy"}) {
    const auto results = [&](const std::string& memory) {
      nlohmann::json found = json(task + " --json" + memory);
      found.erase("seconds");
      return std::pair(found, folder_.read("out.npy"));
    };
    EXPECT_EQ(results(""), results(" --memory 256M")) << task;
  }
  run("generate boxes --count 3000000 --max-edge 200 -o a.npy --quiet");
  expect_error("label a.npy --memory 128M --device native", 5,
               "a.npy: the boxes take at least 154 MiB of memory, more than --memory allows");
  expect_error("label b.csv --memory 20M", 5,
               "a memory budget of 20 MiB is too small: expected at least 32 MiB");
  expect_error("combine \"A or B\" A=b.csv B=a.npy --memory 128M --device native", 5,
               "a.npy: the boxes take at least 155 MiB of memory, more than --memory allows");
}

/// Reading ends within a second of an interrupt, whatever it waits for or expands.
class ReaderInterrupts : public Command {
 protected:
  /// Interrupts `boxunion ARGUMENTS` after half a second.
  void expect_interrupt(const std::string& arguments, const std::string& before = "") {
    const auto start = std::chrono::steady_clock::now();
    const Outcome r = shell(before + "timeout --foreground --preserve-status -k 60 -s INT 0.5 boxunion " +
                            arguments + " --quiet --device native");
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(r.status, 130) << arguments;
    EXPECT_EQ(r.err, "boxunion: error: interrupted\n") << arguments;
    EXPECT_LT(seconds.count(), sanitized() ? 30 : 2.5) << arguments;
  }
};

TEST_F(ReaderInterrupts, EndWaitingForAPipe) {
  shell("mkfifo nobody.csv slow.csv nobody.npy");
  expect_interrupt("measure nobody.csv");
  expect_interrupt("label nobody.csv --memory 256M");
  expect_interrupt("measure slow.csv", "sleep 3 > slow.csv & ");
  expect_interrupt("measure - < slow.csv", "sleep 3 > slow.csv & ");
  const Outcome r = run("measure nobody.npy");
  EXPECT_EQ(r.status, 3);
  EXPECT_NE(r.err.find("cannot read NPY from a pipe"), std::string::npos);
}

TEST_F(ReaderInterrupts, EndReadingScenesAndCompressedVoxels) {
  folder_.write("scene.vox", checkerboards(60, 30'000));
  expect_interrupt("label scene.vox");
  expect_interrupt("measure scene.vox --memory 256M --scratch .");
  std::string zeros;  // ten gigabytes of zeros, compressed
  for (const std::string member = gzip_zeros(100'000'000); zeros.size() < 100 * member.size();)
    zeros += member;
  folder_.write("slices.nrrd",
                "NRRD0004\ntype: uchar\ndimension: 3\nencoding: gzip\nsizes: 1000 1000 10000\n\n" + zeros);
  expect_interrupt("measure slices.nrrd");
}

TEST_F(ReaderInterrupts, AnotherThreadCanEndWaitingForAPipe) {
  shell("mkfifo nobody.csv");
  std::atomic<bool> interrupted = false;
  std::jthread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    interrupted = true;
  });
  try {
    read_boxes(folder_.file("nobody.csv"), &interrupted);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::interrupted);
  }
}

TEST_F(ReaderInterrupts, ATuningFileWithoutEndIsIgnored) {
  folder_.write("a.csv", "0,0,0,1,1,1\n");
  folder_.write("large.json", "");
  std::filesystem::resize_file(folder_.file("large.json"), kLarge);
  for (const auto& [file, warning] :
       {std::pair("/dev/zero", "/dev/zero: not a tuning file: expected a regular file; ignored"),
        std::pair("large.json", "large.json: found more than 1048576 bytes, expected fewer; no tuning")}) {
    const Outcome r =
        shell("export BOXUNION_TUNING="s + file + "; boxunion measure a.csv --quiet --device native");
    EXPECT_EQ(r.status, 0);
    EXPECT_EQ(r.err, "boxunion: warning: "s + warning + "\n");
  }
}

}  // namespace
}  // namespace boxunion

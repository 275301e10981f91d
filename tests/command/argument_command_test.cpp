// Numbers and names on the command line.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "tests/command/command.hpp"

namespace boxunion {
namespace {

using namespace std::string_literals;

class ArgumentCommand : public Command {
 protected:
  ArgumentCommand() { folder_.write("a.csv", "0,0,0,1,1,1\n"); }
};

/// Every option that takes a whole number, with the arguments that it needs, its minimum and its maximum.
const std::vector<std::pair<std::string, std::string>> kWholeNumbers = {
    {"generate cubes -o out.npy --edge 1 --count", "0 to 2^64 - 1"},
    {"generate cubes -o out.npy --count 1 --edge", "0 to 2147483647"},
    {"generate cubes -o out.npy --count 1 --edge 1 --universe", "0 to 2147483647"},
    {"generate cubes -o out.npy --count 1 --edge 1 --seed", "0 to 2^64 - 1"},
    {"generate cubes -o out.npy --count 1 --edge 1 --threads", "0 to 4096"},
    {"generate boxes -o out.npy --max-edge 1 --count", "0 to 2^64 - 1"},
    {"generate boxes -o out.npy --count 1 --max-edge", "0 to 2147483647"},
    {"generate boxes -o out.npy --count 1 --max-edge 1 --min-edge", "0 to 2147483647"},
    {"generate boxes -o out.npy --count 1 --max-edge 1 --universe", "0 to 2147483647"},
    {"generate boxes -o out.npy --count 1 --max-edge 1 --seed", "0 to 2^64 - 1"},
    {"generate checkerboard -o out.npy --size", "0 to 2147483647"},
    {"generate sponge -o out.npy --level", "0 to 2147483647"},
    {"generate phantom -o out.npy --size", "0 to 2147483647"},
    {"generate phantom -o out.npy --size 2 2", "0 to 2147483647"},
    {"generate porous -o out.npy --size", "0 to 2147483647"},
    {"generate porous -o out.npy --size 2 --feature", "0 to 2147483647"},
    {"generate porous -o out.npy --size 2 --seed", "0 to 2^64 - 1"},
    {"measure a.csv --threads", "0 to 4096"},
    {"measure a.csv --cell", "0 to 524288"},
    {"measure a.csv --workgroup", "0 to 1024"},
    {"measure a.csv --model", "1 to 4294967295"},
    {"boundary a.csv -o out.npy --threads", "0 to 4096"},
    {"decompose a.csv --vox-model", "1 to 4294967295"},
    {"label a.csv --threads", "0 to 4096"},
    {"combine A A=a.csv --cell", "0 to 524288"},
    {"bench --size", "1 to 1048576"},
    {"bench --size 32,", "1 to 1048576"},
    {"bench --workgroup", "1 to 1024"},
    {"bench --repetitions", "1 to 100000"},
    {"bench --threads", "0 to 4096"},
};

TEST_F(ArgumentCommand, OnlyWholeNumbersInRangeAreAccepted) {
  for (const auto& [start, range] : kWholeNumbers) {
    const bool is_list = start.ends_with(',');
    const std::size_t option_at = start.rfind("--");
    const std::string option = start.substr(option_at, start.find(' ', option_at) - option_at);
    for (const std::string value : {"-1", "-5", "99999999999999999999", "1e99", "1.5", "0x10", "1e-3", "many",
                                    "5x", "1K", "1.5G", "nan", "inf"})
      expect_error(start + (is_list ? "" : " ") + value, 2,
                   option + ": found \"" + value + "\", expected a whole number from " + range);
  }
  expect_error("measure a.csv --threads ''", 2,
               "--threads: found \"\", expected a whole number from 0 to 4096");
  EXPECT_EQ(folder_.file_count(), 1u);
}

TEST_F(ArgumentCommand, NoOptionTakesANumberUnchecked) {
  const std::regex number_option("(--[a-z-]+) (UINT|INT|FLOAT|SIZE)");
  std::size_t options = 0;
  for (const std::string task : {"measure", "boundary", "decompose", "label", "combine", "generate cubes",
                                 "generate boxes", "generate checkerboard", "generate sponge",
                                 "generate phantom", "generate porous", "devices", "bench"}) {
    const std::string help = run(task + " --help").out;
    for (std::sregex_iterator match(help.begin(), help.end(), number_option), end; match != end; ++match) {
      const std::string option = (*match)[1];
      const Outcome r = run(task + " " + option + " 7up");
      EXPECT_EQ(r.status, 2) << task << option;
      EXPECT_TRUE(r.err.starts_with("boxunion: error: " + option + ": found \"7up\", expected ")) << r.err;
      ++options;
    }
  }
  EXPECT_GT(options, 40u);
}

TEST_F(ArgumentCommand, WholeNumbersMayHaveAnExponent) {
  for (const auto& [value, count] :
       {std::pair{"1e3", 1000}, {"2.5e2", 250}, {"1000.0", 1000}, {"+7", 7}, {"0", 0}})
    EXPECT_EQ(json("generate cubes --json -o out.npy --edge 1 --count "s + value).at("boxes"), count)
        << value;
  run("generate cubes --count 10 --edge 1 -o a.npy --seed 18446744073709551615");
  run("generate cubes --count 10 --edge 1 -o b.npy --seed 18446744073709551614");
  run("generate cubes --count 10 --edge 1 -o c.npy --seed 18446744073709551615 --universe 3.2768e4");
  EXPECT_NE(folder_.read("a.npy"), folder_.read("b.npy"));
  EXPECT_EQ(folder_.read("a.npy"), folder_.read("c.npy"));
}

TEST_F(ArgumentCommand, SizesHaveUnits) {
  const auto expected = [&](const std::string& size, const std::string& mebibytes) {
    expect_error("measure a.csv --memory '" + size + "'", 5,
                 "a memory budget of " + mebibytes + " MiB is too small: expected at least 100 MiB");
  };
  expected("52428800", "50");
  expected("50M", "50");
  expected("50MB", "50");
  expected("50mib", "50");
  expected("50 MiB", "50");
  expected("51200k", "50");
  expected("0.0625G", "64");
  expected("1e6", "1");
  for (const std::string size : {"1.5G", "512MiB", "1e9", "0.001T", "1.5 GB"})
    EXPECT_EQ(json("measure a.csv --json --memory '" + size + "'").at("volume"), 1) << size;
  for (const std::string size : {"-1", "-1G", "0", "0M", "99999999999999999999", "20000000T", "much", "1Q",
                                 "1MM", "G", "1.5.5G", "nanG", "infG", "0x10M", ""})
    for (const std::string task : {"measure a.csv", "boundary a.csv -o out.csv", "decompose a.csv"})
      expect_error(task + " --memory '" + size + "'", 2,
                   "--memory: found \"" + size + "\", expected a size such as 512M, 1.5G or 2GiB");
}

TEST_F(ArgumentCommand, OtherNumbersAreFinite) {
  for (const std::string value : {"many", "nan", "inf", "1e999", "0x10", "1,5", ""}) {
    const std::string message = ": found \"" + value + "\", expected a finite number";
    expect_error("measure a.csv --threshold '" + value + "'", 2, "--threshold" + message);
    expect_error("generate porous --size 2 -o out.npy --porosity '" + value + "'", 2, "--porosity" + message);
  }
  run("generate phantom --size 8 --volume -o v.npy");
  EXPECT_EQ(json("measure v.npy --threshold -1.5e0 --json").at("volume"), 512);
  EXPECT_EQ(json("measure v.npy --threshold +2 --json").at("volume"), 0);
}

bool is_printable(const std::string& text) {
  return std::ranges::all_of(text, [](unsigned char c) { return (c >= ' ' && c != 0x7f) || c == '\n'; });
}

TEST_F(ArgumentCommand, NamesOfAnyBytesAreShownSafely) {
  // colors, a new line, a bell, half a character, a C1 control, a character, a quote
  const std::string name = "a\x1b[31m\nb\t\x07\x7f\xc3(\xc2\x9b\xe2\x82\xac\xed\xa0\x80'\"'\"'\"\\.csv";
  const std::string file = "a\x1b[31m\nb\t\x07\x7f\xc3(\xc2\x9b\xe2\x82\xac\xed\xa0\x80'\"\\.csv";
  const std::string shown = "a\\x1b[31m\\nb\\t\\x07\\x7f\\xc3(\\xc2\\x9b\xe2\x82\xac\\xed\\xa0\\x80'\"\\.csv";
  folder_.write("a.csv", "0,0,0,0.1,1,1\n");
  Outcome r = run("decompose a.csv --order xyz -o '" + name + "'");
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_NE(r.out.find("output   " + shown + "\n"), std::string::npos) << r.out;
  EXPECT_TRUE(is_printable(r.out));
  EXPECT_TRUE(std::filesystem::exists(folder_.file(file)));

  const nlohmann::json result =
      json("decompose a.csv --json -o '" + name + "'");  // json throws for bytes that are not UTF-8
  EXPECT_EQ(
      result.at("output"),
      "a\x1b[31m\nb\t\x07\x7f\xef\xbf\xbd(\xc2\x9b\xe2\x82\xac\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd'\"\\.csv");
  r = run("decompose a.csv --json -o '" + name + "'");
  EXPECT_TRUE(is_printable(r.out));
  EXPECT_EQ(r.out.find('\n'), r.out.size() - 1);

  r = run("combine A A='" + name + "'");
  EXPECT_NE(r.out.find("A: 1 boxes of " + shown + "\n"), std::string::npos) << r.out;
  EXPECT_EQ(json("combine A A='" + name + "' --json").at("sets").at("A").at("boxes"), 1);
  folder_.write("none.csv", "");
  expect_error("measure 'none/" + name + "'", 3,
               "none/" + shown + ": cannot read: No such file or directory");
  expect_error("measure a.csv --threads '\x1b[31m\xff'", 2,
               "--threads: found \"\\x1b[31m\\xff\", expected a whole number from 0 to 4096");
  r = run("boundary a.csv -o '\x1b[31m.stl'");
  EXPECT_EQ(r.err,
            "boxunion: warning: \\x1b[31m.stl: coordinates were rounded to the numbers of this format\n");
  r = shell("printf '{' >'\x1b[31m'; BOXUNION_TUNING='\x1b[31m' boxunion measure a.csv");
  EXPECT_TRUE(r.err.starts_with("boxunion: warning: \\x1b[31m: not a tuning file")) << r.err;
}

}  // namespace
}  // namespace boxunion

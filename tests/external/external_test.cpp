// More boxes than memory. The result is the same to the last bit for any budget, and nothing is left behind.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "core/boxes/cuts.hpp"
#include "host/engine/threads.hpp"
#include "host/external/external_boundary.hpp"
#include "host/external/external_decomposition.hpp"
#include "host/external/external_union.hpp"
#include "tests/command/command.hpp"
#include "tests/device/every_device.hpp"
#include "tests/external/external_inputs.hpp"
#include "tests/support/boxes_in_memory.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

std::vector<PlacedVertex> placed(const Solid& solid) {
  std::vector<PlacedVertex> all;
  for (const Vertex& v : solid.vertices) all.push_back(place(v, solid.axes));
  return all;
}

struct External : EveryDevice {
  /// Compares both results of slabs of at most `most` boxes with those from memory.
  static void expect_same(const Input& input, const Options& options, std::uint64_t most) try {
    SCOPED_TRACE(input.name + ", slabs of " + std::to_string(most));
    const BoxesInMemory file(input.boxes);
    const TemporaryFolder scratch;
    const Budget budget{std::uint64_t{2} << 30, scratch.path(), most};
    Report report;
    ExternalUnion by_mass(file, options, budget, report);
    EXPECT_TRUE(by_mass.measure() == measure(input.boxes, options));
    EXPECT_EQ(by_mass.degenerate_boxes(), count_degenerate(input.boxes));
    EXPECT_EQ(by_mass.slabs() > 1, input.boxes.size() - count_degenerate(input.boxes) > most);

    std::vector<PlacedVertex> found;
    std::uint64_t announced = 0;
    ExternalUnion(file, options, budget, report).vertices([&](std::uint64_t count) {
      announced = count;
      return
          [&](std::span<const PlacedVertex> block) { found.insert(found.end(), block.begin(), block.end()); };
    });
    const std::vector<PlacedVertex> expected = placed(unite(input.boxes, options));
    EXPECT_EQ(announced, found.size());
    EXPECT_TRUE(std::ranges::equal(found, expected, [](const PlacedVertex& a, const PlacedVertex& b) {
      return a.point == b.point && a.mask == b.mask;
    }));
    EXPECT_EQ(scratch.file_count(), 0u);
  } catch (const Error& error) {
    ADD_FAILURE() << input.name << ", slabs of " << most << ": " << error.what();
  }
};
INSTANTIATE_TEST_SUITE_P(Devices, External, testing::ValuesIn(device_ids()), device_name);

TEST_P(External, IsTheSameToTheLastBitInSlabsOfAnySize) {
  const bool native = GetParam() == "native";
  for (const Input& input : external_inputs())
    for (const Method method : {Method::cells, Method::slices}) {
      if (method == Method::slices && input.name != "dense" && input.name != "touching" &&
          input.name != "mixed")
        continue;  // the others have many rectangles in their slabs
      // a device is opened for every slab
      if (!native && (method == Method::slices || input.name != "doubles")) continue;
      std::vector<std::uint64_t> sizes = {native ? 1000u : 2000u, 1'000'000};
      // at great depth, cuts copy more boxes than they separate, which is an error; another test covers that
      if (native && method == Method::cells && (input.name == "sparse" || input.name == "doubles"))
        sizes.push_back(60);
      if (input.name == "clustered") sizes = {1500, 1'000'000};
      for (const std::uint64_t most : sizes) {
        if (most < 1'000'000 && (input.name == "wide" || input.name == "large" || input.name == "degenerate"))
          continue;  // almost no cut separates these
        expect_same(input, {.method = method, .device = GetParam()}, most);
      }
    }
}

// The integrals over slabs add up, and so do the sums over all vertices, but a mixture of both does not.
TEST(ExternalMass, SlabsOfFewBoxesAreSummedInOneWay) {
  const TemporaryFolder scratch;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const BoxSet boxes = collect(generate_cubes(85, 1092, 14840, seed));
    const BoxesInMemory file(boxes);
    Report report;
    const Options options{.device = "native"};
    ExternalUnion slabs(file, options, {std::uint64_t{1} << 30, scratch.path(), 4 + seed % 8}, report);
    try {
      EXPECT_TRUE(slabs.measure() == measure(boxes, options)) << "seed " << seed;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::resources);  // no cut helps
    }
  }
}

TEST(ExternalStatistics, AreThoseFromMemory) {
  const TemporaryFolder scratch;
  for (const Input& input : external_inputs()) {
    SCOPED_TRACE(input.name);
    const bool deep = input.name == "wide" || input.name == "large" || input.name == "degenerate";
    const BoxesInMemory file(input.boxes);
    const Options options{.device = "native", .statistics = true};
    Report expected, found;
    const MassProperties mass = measure(input.boxes, options, &expected);
    ExternalUnion slabs(file, options, {std::uint64_t{1} << 30, scratch.path(), deep ? 0 : 1500u}, found);
    EXPECT_TRUE(slabs.measure() == mass);
    ASSERT_TRUE(found.statistics);
    EXPECT_EQ(found.statistics->boxes, expected.statistics->boxes);
    EXPECT_EQ(found.statistics->vertices, expected.statistics->vertices);
    EXPECT_EQ(found.cells.cells > 0, expected.cells.cells > 0);
  }
}

TEST(ExternalCuts, GoAsFarAsTheyHelp) {
  const BoxSet wide = collect(generate_boxes(2000, 1, 1 << 28, (1ll << 31) - 1, 5));
  External::expect_same({"wide", wide}, {.device = "native"}, 900);
  const BoxSet large = collect(generate_boxes(500, 1, 900, 10'000, 5));
  External::expect_same({"large", large}, {.device = "native"}, 100);
}

/// The message of the engine's error, or "".
std::string error_of(const BoxSet& boxes, const Budget& budget, ErrorKind kind) try {
  const BoxesInMemory file(boxes);
  Report report;
  const Options options{.device = "native"};
  ExternalUnion(file, options, budget, report).measure();
  return "";
} catch (const Error& error) {
  EXPECT_EQ(error.kind(), kind);
  return error.what();
}

TEST(ExternalErrors, SayWhatIsNeeded) {
  const TemporaryFolder scratch;
  const Budget budget{std::uint64_t{1} << 30, scratch.path(), 100};
  const BoxSet alike(std::vector<IntegerBox>(1000, IntegerBox{0, 0, 0, 9, 9, 9}));
  EXPECT_EQ(
      error_of(alike, budget, ErrorKind::resources),
      "1000 boxes overlap so deeply that no cut separates them: they need about 97 MiB of memory, but the "
      "budget is 1024 MiB");
  EXPECT_EQ(error_of(alike, {1 << 20, scratch.path()}, ErrorKind::resources),
            "a memory budget of 1 MiB is too small: expected at least 100 MiB");
  EXPECT_EQ(error_of(collect(generate_cubes(1000, 2, 100, 1)), {std::uint64_t{1} << 30, "/none", 100},
                     ErrorKind::input),
            "/none: cannot create scratch files: No such file or directory");
}

TEST(ExternalErrors, TheFirstInvalidBoxWins) {
  std::vector<Box> boxes(300'000, Box{0, 0, 0, 1, 1, 1});
  boxes[299'999] = boxes[150'000] = {0, 0, 0, 1, -1, 1};
  EXPECT_EQ(error_of(boxes, {std::uint64_t{1} << 30, "/tmp"}, ErrorKind::input),
            "row 150001: ymin is 0 and ymax is -1, expected ymin <= ymax");
}

/// Boxes that share a corner cannot be separated by cuts, but need little memory in one piece.
TEST(ExternalUnion, SweepsBoxesWithACommonCorner) {
  std::mt19937_64 random(9);
  std::vector<Box> general;
  std::vector<IntegerBox> integers;
  for (int i = 0; i < 20'000; ++i) {
    const auto reach = [&] { return 1 + int(random() % 1'000'000); };
    integers.push_back({0, -reach(), 0, reach(), 0, reach()});
    const auto low = [&] { return 1 - std::ldexp(double(random() % (1u << 30)), -int(random() % 40) - 30); };
    general.push_back({low(), low(), low(), 1, 1, 1});
  }
  const TemporaryFolder scratch;
  for (const BoxSet& boxes : {BoxSet(general), BoxSet(integers)}) {
    const BoxesInMemory file(boxes);
    Report report;
    ExternalUnion solid(file, {.device = "native"}, {std::uint64_t{110} << 20, scratch.path()}, report);
    EXPECT_EQ(solid.measure(), measure(boxes, {.method = Method::cells, .device = "native"}));
    EXPECT_EQ(report.method, "staircase");
  }
}

TEST(ExternalProgress, RisesFromTheFirstSlabToTheEnd) {
  const BoxSet boxes = collect(generate_cubes(20'000, 40, 2000, 1));
  const BoxesInMemory file(boxes);
  const TemporaryFolder folder, scratch;
  const auto check = [&](auto&& run) {
    std::vector<double> shown;
    Options options{.device = "native"};
    options.progress = [&](double fraction) { shown.push_back(fraction); };
    Report report;
    with_threads({.threads = 1}, [&] {
      ExternalUnion solid(file, options, {std::uint64_t{110} << 20, scratch.path(), 3000}, report);
      run(solid, report);
    });
    EXPECT_GT(shown.size(), 10u);
    EXPECT_LT(shown.front(), 0.2);
    EXPECT_TRUE(std::ranges::is_sorted(shown));
    EXPECT_EQ(shown.back(), 1);
  };
  for (const NonManifold contacts : {NonManifold::keep, NonManifold::split})
    check([&](ExternalUnion& solid, Report& report) {
      write_boundary(solid, contacts, false, open_output(folder.file("a.ply"), FileUse::boundary), report);
    });
  for (const std::optional<AxisOrder> order : {std::optional(kAxisOrders[1]), std::optional<AxisOrder>()})
    check([&](ExternalUnion& solid, Report& report) {
      decompose(solid, BoxModel::cudb, order, {}, open_output(folder.file("a.npy")), report);
    });
  check([&](ExternalUnion& solid, Report& report) {
    decompose(solid, BoxModel::oudb, kAxisOrders[3], Connectivity::faces, open_output(folder.file("a.npy")),
              report);
  });
  check([&](ExternalUnion& solid, Report& report) {
    decompose(solid, {}, kAxisOrders[2], {}, open_output(folder.file("a.npy")), report);
  });
}

TEST(Cuts, GiveEverySlabItsShare) {
  std::mt19937_64 random(7);
  std::vector<Box> boxes;
  for (int i = 0; i < 20'000; ++i) {
    const double x = double(random() % 1000), z = std::pow(double(random() % 1000), 3);
    boxes.push_back({x, 0, z, x + 1, 1, z + 100});
  }
  const auto cuts = choose_cuts(boxes, 0.1, 64);
  ASSERT_TRUE(cuts);
  EXPECT_NE(cuts->axis, 1);  // all boxes are equal on this axis
  EXPECT_LE(cuts->largest, 0.1);
  EXPECT_LT(cuts->copies, 1.1);
  EXPECT_TRUE(std::ranges::is_sorted(cuts->at));
  double begin = -INFINITY;
  for (std::size_t slab = 0; slab <= cuts->at.size(); ++slab) {
    const double end = slab < cuts->at.size() ? cuts->at[slab] : INFINITY;
    const auto axis = std::size_t(cuts->axis);
    const auto touches = [&](const Box& box) { return box[axis] < end && box[axis + 3] >= begin; };
    EXPECT_LE(std::ranges::count_if(boxes, touches), 2000);
    begin = end;
  }
  EXPECT_FALSE(choose_cuts(std::vector<Box>(100, Box{0, 0, 0, 1, 1, 1}), 0.1, 64));
}

/// The results without the parts that differ between runs.
nlohmann::json results(nlohmann::json json) {
  for (const char* key : {"seconds", "slabs"}) json.erase(key);
  return json;
}

TEST_F(Command, AMemoryBudgetIsKeptAndChangesNoResult) {
  if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any limit";
  run("generate cubes --count 2000000 --edge 60 -o a.npy --quiet");
  const std::string native = " --json --device native --threads 2";
  const nlohmann::json expected = results(json("measure a.npy" + native));
  for (const std::string memory : {"102M", "120M", "1G"}) {
    const nlohmann::json found = json("measure a.npy --memory " + memory + native);
    EXPECT_EQ(results(found), expected) << memory;
    EXPECT_EQ(found.at("slabs") == 1, memory == "1G");
  }
  const auto statistics = [&](const std::string& memory) {
    nlohmann::json found = json("measure a.npy --statistics" + memory + native).at("statistics");
    for (const char* key : {"cells", "covered_cells", "cell_box_overlaps"}) EXPECT_EQ(found.erase(key), 1u);
    return found;
  };
  EXPECT_EQ(statistics(" --memory 102M"), statistics(""));
  // 200 000 KB for boxes that take 240 MB as doubles, and more as vertices
  run("generate boxes --count 200000 --max-edge 60 -o b.csv --quiet");
  run("boundary b.csv -o expected.npy --device native");
  for (const std::string out : {"v.npy", "v.csv"}) {
    const Outcome r = shell("ulimit -v 300000; boxunion boundary b.csv --memory 128M -o " + out + native);
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_GT(nlohmann::json::parse(r.out).at("slabs"), 1);
  }
  EXPECT_TRUE(folder_.read("v.npy") == folder_.read("expected.npy"));
  run("boundary b.csv -o expected.csv --device native");
  EXPECT_TRUE(folder_.read("v.csv") == folder_.read("expected.csv"));
  const Outcome piped = run("measure - --memory 128M < b.csv");
  EXPECT_EQ(piped.status, 0) << piped.err;
}

TEST_F(Command, ABudgetThatCannotBeKeptExitsWith5) {
  run("generate cubes --count 3000 --edge 60 -o a.npy --quiet");
  expect_error("boundary a.npy -o a.3mf --memory 50M", 5,
               "a memory budget of 50 MiB is too small: expected at least 100 MiB");
  EXPECT_EQ(folder_.file_count(), 1u);
  expect_error("measure a.npy --memory much", 2,
               "--memory: found \"much\", expected a size such as 512M, 1.5G or 2GiB");
  expect_error("measure a.npy --scratch .", 2, "--scratch requires --memory");
}

TEST_F(Command, ScratchFilesAreGoneHoweverARunEnds) {
  run("generate cubes --count 6000000 --edge 30 -o a.npy --quiet");
  std::filesystem::create_directory(folder_.file("scratch"));
  const auto left = [&] {
    return std::distance(std::filesystem::directory_iterator(folder_.file("scratch")), {});
  };
  const std::string measure = " measure a.npy --memory 104M --scratch scratch --device native";
  EXPECT_EQ(run(measure).status, 0);
  EXPECT_EQ(left(), 0);
  for (const std::string& seconds : interrupt_times()) {
    const Outcome r =
        shell("timeout --foreground --preserve-status -k 30 -s INT " + seconds + " boxunion" + measure);
    EXPECT_EQ(r.status, 130);
    EXPECT_EQ(r.err, "boxunion: error: interrupted\n");
    EXPECT_EQ(left(), 0);
  }
  for (const std::string made :
       {"decompose a.npy -o b.npy", "boundary a.npy -o b.ply", "boundary a.npy -o b.3mf"}) {
    const Outcome r = shell("timeout --foreground --preserve-status -k 30 -s INT " + interrupt_times()[1] +
                            " boxunion " + made + " --memory 104M --scratch scratch --device native");
    EXPECT_EQ(r.status, 130);
    EXPECT_EQ(r.err, "boxunion: error: interrupted\n");
    EXPECT_EQ(left(), 0);
    EXPECT_EQ(folder_.file_count(), 2u);  // a.npy and the folder
  }
  const Outcome killed = shell("timeout --foreground -s KILL 0.2 boxunion" + measure);
  EXPECT_NE(killed.status, 0);
  EXPECT_EQ(left(), 0);
  const Outcome full = shell("trap '' XFSZ; ulimit -f 1000; boxunion" + measure);
  EXPECT_EQ(full.status, 5);
  EXPECT_EQ(full.err, "boxunion: error: scratch: cannot write scratch files: File too large\n");
  EXPECT_EQ(left(), 0);
  expect_error("measure a.npy --memory 104M --scratch none", 3,
               "none: cannot create scratch files: No such file or directory");
}

}  // namespace
}  // namespace boxunion

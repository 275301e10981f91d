// Models of solids that do not fit memory have the same files as those from memory, to the byte.

#include "host/external/external_decomposition.hpp"

#include <gtest/gtest.h>
#include <stdio.h>

#include <array>
#include <filesystem>
#include <numeric>
#include <optional>
#include <random>

#include "boxunion/components.hpp"
#include "boxunion/error.hpp"
#include "host/external/sorted_runs.hpp"
#include "tests/command/command.hpp"
#include "tests/external/external_inputs.hpp"
#include "tests/support/boxes_in_memory.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

TEST(SortedRuns, AreMergedInOrderAndAgain) {
  std::vector<std::uint64_t> numbers(200'000);
  std::iota(numbers.begin(), numbers.end(), 0);
  std::vector<std::uint64_t> shuffled = numbers;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(1));
  SortedRuns<std::uint64_t> runs(1, thread_count(), ScratchFile(default_scratch_folder()));  // of 1024 each
  parallel_ranges(0, shuffled.size(), 1000, [&](std::size_t begin, std::size_t end) {
    runs.add(std::span(shuffled).subspan(begin, end - begin));
  });
  EXPECT_EQ(runs.count(), numbers.size());
  for (const std::uint64_t bytes : {1, 1 << 20}) {
    std::vector<std::uint64_t> merged;
    runs.merge(bytes, [&](std::span<const std::uint64_t> block) {
      merged.insert(merged.end(), block.begin(), block.end());
    });
    EXPECT_TRUE(merged == numbers);
  }
}

struct Wanted {
  std::optional<BoxModel> model;
  std::optional<AxisOrder> order;
  std::optional<Connectivity> connectivity;
};

/// Makes the model in memory. Returns its order and number of elements.
ExternalModel write_from_memory(const BoxSet& boxes, const Wanted& wanted, const std::string& path) {
  const Solid solid = unite(boxes, {.device = "native"});
  const auto write = [&](const Evm& evm) -> ExternalModel {
    if (!wanted.model) {
      write_extreme_vertices(evm, open_output(path));
      return {evm.order, evm.vertices.size(), 0};
    }
    const Decomposition found = decompose(evm, *wanted.model);
    write_boxes(to_boxes(found), open_output(path));
    return {evm.order, found.boxes.size(),
            wanted.connectivity ? find_neighbors(found, *wanted.connectivity).pairs() : 0};
  };
  AxisOrder best = wanted.order.value_or(kAxisOrders[0]);
  if (!wanted.order && wanted.model)
    for (const AxisOrder& order : kAxisOrders)
      if (count_boxes(make_evm(solid, order), *wanted.model) <
          count_boxes(make_evm(solid, best), *wanted.model))
        best = order;
  return write(make_evm(solid, best));
}

ExternalModel write_within(const BoxSet& boxes, const Wanted& wanted, const Budget& budget,
                           const std::string& path) {
  const BoxesInMemory file(boxes);
  Report report;
  const Options options{.device = "native"};
  ExternalUnion solid(file, options, budget, report);
  std::optional<OutputFile> output;
  if (!path.empty()) output.emplace(open_output(path));
  return decompose(solid, wanted.model, wanted.order, wanted.connectivity, std::move(output), report);
}

TEST(ExternalDecomposition, IsTheSameToTheByteForEveryModelAndOrder) {
  std::mt19937_64 random(std::random_device{}());
  const TemporaryFolder folder, scratch;
  for (const Input& input : external_inputs()) {
    if (sanitized() && random() % 3 != 0) continue;  // takes a minute
    for (const std::optional<BoxModel> model :
         {std::optional<BoxModel>(), std::optional(BoxModel::oudb), std::optional(BoxModel::cudb)}) {
      // a slice of the OUDB has all lines of the section
      if (model == BoxModel::oudb && (input.name == "wide" || input.name == "doubles")) continue;
      const bool deep = input.name == "wide" || input.name == "large" || input.name == "degenerate";
      std::vector<std::optional<AxisOrder>> orders = {kAxisOrders[random() % 6]};
      if (model == BoxModel::cudb || input.name == "touching") orders.push_back(std::nullopt);
      for (const std::optional<AxisOrder>& order : orders) {
        SCOPED_TRACE(input.name + ", model " + std::to_string(model ? int(*model) : -1) + ", order " +
                     (order ? to_string(*order) : "best"));
        const std::string end = random() % 4 == 0 ? ".csv" : ".npy";
        const Wanted wanted{model, order,
                            std::array{std::optional<Connectivity>(), std::optional(Connectivity::faces),
                                       std::optional(Connectivity::points)}[random() % 3]};
        const ExternalModel expected = write_from_memory(input.boxes, wanted, folder.file("memory" + end));
        const Budget budget{std::uint64_t{1} << 30, scratch.path(),
                            deep                        ? 0
                            : input.name == "clustered" ? 1500u
                                                        : 500u};
        const ExternalModel found = write_within(input.boxes, wanted, budget, folder.file("slabs" + end));
        EXPECT_EQ(found.order, expected.order);
        EXPECT_EQ(found.elements, expected.elements);
        EXPECT_EQ(found.pairs, expected.pairs);
        EXPECT_TRUE(folder.read("slabs" + end) == folder.read("memory" + end));
        EXPECT_EQ(write_within(input.boxes, wanted, budget, "").elements, expected.elements);
        EXPECT_EQ(scratch.file_count(), 0u);
      }
    }
  }
}

TEST(ExternalDecomposition, SaysWhatASectionThatDoesNotFitNeeds) {
  // one section of 90 000 rectangles
  std::vector<IntegerBox> pillars;
  for (int x = 0; x < 300; ++x)
    for (int y = 0; y < 300; ++y) pillars.push_back({2 * x, 2 * y, 0, 2 * x + 1, 2 * y + 1, 1 + (x + y) % 3});
  const TemporaryFolder folder, scratch;
  const std::string path = folder.file("a.npy");
  for (const BoxModel model : {BoxModel::oudb, BoxModel::cudb}) {
    const Wanted wanted{model, AxisOrder{2, 1, 0}, {}};
    unsigned need = 110, errors = 0;
    for (std::uint64_t found = 0; found == 0 && errors < 5;) try {
        found = write_within(pillars, wanted, {std::uint64_t{need} << 20, scratch.path()}, path).elements;
        EXPECT_EQ(found, model == BoxModel::oudb ? 180'000u : 90'000u);
        EXPECT_EQ(std::filesystem::remove(path), true);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::resources);
        const char* const message =
            "a section of the sweep along z does not fit the budget: expected --memory of at least %u MiB";
        const unsigned before = need;
        ASSERT_EQ(::sscanf(error.what(), message, &need), 1) << error.what();
        EXPECT_GT(need, before);
        ++errors;
        EXPECT_EQ(folder.file_count(), 0u);
        EXPECT_EQ(scratch.file_count(), 0u);
      }
    EXPECT_GT(errors, 0u);
    EXPECT_LT(errors, 5u);  // later sections may take more
    EXPECT_LT(need, 300u);
    // along x, a section is a row of pillars
    EXPECT_EQ(
        write_within(pillars, {model, AxisOrder{0, 1, 2}, {}}, {110 << 20, scratch.path()}, "").elements,
        90'000u);
  }
}

TEST_F(Command, DecompositionsKeepToTheBudget) {
  if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any limit";
  run("generate boxes --count 100000 --max-edge 60 -o a.npy --quiet");
  const auto results = [](nlohmann::json json) {
    for (const char* key : {"seconds", "slabs"}) json.erase(key);
    return json;
  };
  for (const std::string options : {"--model cudb -o b.npy", "--connectivity 26 --order yxz -o b.npy",
                                    "--model evm --order zyx -o b.csv"}) {
    const std::string decompose = " decompose a.npy --json --device native --threads 2 " + options;
    const nlohmann::json expected = results(json(decompose));
    const std::string file = options.substr(options.rfind(' ') + 1), bytes = folder_.read(file);
    const Outcome r = shell("ulimit -v 300000; boxunion" + decompose + " --memory 106M");
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(results(nlohmann::json::parse(r.out)), expected);
    EXPECT_GT(nlohmann::json::parse(r.out).at("slabs"), 1);
    EXPECT_TRUE(folder_.read(file) == bytes);
  }
}

}  // namespace
}  // namespace boxunion

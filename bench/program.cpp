#include "bench/program.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <set>

namespace boxunion {

int run_benchmark(int argc, char** argv, const std::string& description, Request defaults,
                  const std::function<void(const Request&, Tables&)>& run) try {
  CLI::App app(description);
  std::string json;
  app.add_option("runs", defaults.runs, "Runs of which the median counts")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  if (!defaults.counts.empty())
    app.add_option("counts", defaults.counts, "Numbers of boxes")
        ->check(CLI::Range(1, 1'000'000'000))
        ->capture_default_str();
  if (!defaults.sections.empty())
    app.add_option("sections", defaults.sections, "What to measure; all by default")
        ->check(CLI::IsMember(std::set<std::string>(defaults.sections.begin(), defaults.sections.end())));
  app.add_option("--json", json, "Write the tables to FILE, too")->type_name("FILE");
  CLI11_PARSE(app, argc, argv);

  Tables tables;
  run(defaults, tables);
  if (!json.empty()) tables.write(json);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}

}  // namespace boxunion

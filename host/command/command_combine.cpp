#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "boxunion/decomposition.hpp"
#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/base/parallel.hpp"
#include "core/cells/expression.hpp"
#include "host/command/boundary_writer.hpp"
#include "host/command/command_memory.hpp"
#include "host/command/command_results.hpp"
#include "host/engine/threads.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {
namespace {

/// A set of boxes, as given on the command line.
struct NamedFile {
  std::string name, path;
};

NamedFile parse_set(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos || equals + 1 == argument.size())
    throw Error(ErrorKind::usage, fmt::format("\"{}\": expected NAME=FILE", argument));
  const std::string name = argument.substr(0, equals);
  if (!Expression::is_name(name))
    throw Error(ErrorKind::usage, fmt::format("\"{}\": an expression has no such name", argument));
  return {name, argument.substr(equals + 1)};
}

/// The files of an expression's sets, in its order. Warns of files that it does not name.
std::vector<NamedFile> find_files(const Expression& expression, const std::vector<std::string>& arguments) {
  std::vector<NamedFile> given;
  for (const std::string& argument : arguments) {
    given.push_back(parse_set(argument));
    if (std::ranges::count(given, given.back().name, &NamedFile::name) > 1)
      throw Error(ErrorKind::usage, fmt::format("{} is given twice", given.back().name));
  }
  std::vector<NamedFile> files;
  for (std::size_t i = 0; i < expression.names().size(); ++i) {
    const std::string& name = expression.names()[i];
    const auto found = std::ranges::find(given, name, &NamedFile::name);
    if (found == given.end())
      throw Error(ErrorKind::usage, fmt::format("expression, column {}: {} is not given: expected {}=FILE",
                                                expression.columns()[i], name, name));
    files.push_back(*found);
  }
  if (std::ranges::count(files, "-", &NamedFile::path) > 1)
    throw Error(ErrorKind::usage, "standard input can be only one of the sets");
  for (const NamedFile& file : given)
    if (std::ranges::find(expression.names(), file.name) == expression.names().end())
      warn(fmt::format("{} is given, but the expression does not name it", file.name));
  return files;
}

MassProperties mass_of(const Solid& solid) {
  MassSink sink(solid.axes);
  parallel_ranges(0, solid.vertices.size(), std::size_t{1} << 14, [&](std::size_t begin, std::size_t end) {
    sink.add(std::span(solid.vertices).subspan(begin, end - begin));
  });
  return sink.result();
}

/// The number of boxes of each set and of all sets together.
std::vector<Result> set_results(const std::vector<NamedFile>& files, const std::vector<BoxSet>& sets) {
  std::string json, text;
  std::size_t boxes = 0, degenerate = 0;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    json += fmt::format("{}{}: {{\"file\": {}, \"boxes\": {}}}", i ? ", " : "", json_string(files[i].name),
                        json_string(files[i].path), sets[i].size());
    text += fmt::format("{}{}: {} boxes of {}", i ? "\n" : "", files[i].name, sets[i].size(),
                        printable(files[i].path));
    boxes += sets[i].size();
    degenerate += count_degenerate(sets[i]);
  }
  return {{"sets", fmt::format("{{{}}}", json), text},
          count_result("boxes", boxes),
          count_result("degenerate_boxes", degenerate)};
}

}  // namespace

void combine(const std::string& text, const std::vector<std::string>& arguments, const std::string& output,
             const std::string& boxes, const BoundaryOptions& boundary_options, const Common& common) {
  const Expression expression = Expression::parse(text);
  const std::vector<NamedFile> files = find_files(expression, arguments);
  ProgressBar bar(common.quiet);
  HeldBoxes held(common);
  OutputGroup outputs;
  std::optional<BoundaryWriter> writer;
  if (!output.empty()) writer.emplace(output, boundary_options, common, outputs);
  std::optional<OutputFile> boxes_file;
  if (!boxes.empty()) boxes_file.emplace(open_output(boxes, FileUse::boxes, &outputs));
  const Options options = engine_options(common, bar);
  Report report;
  std::vector<Result> results{string_result("expression", text)};
  with_threads(common.engine, [&] {
    std::vector<BoxSet> sets;
    sets.reserve(files.size());
    for (const NamedFile& file : files) sets.push_back(held.read(file.path));
    for (const Result& result : set_results(files, sets)) results.push_back(result);
    MassProperties mass;
    if (writer || boxes_file) {
      bar.show_part(0, 0.3);
      const Solid solid = boxunion::combine(expression, sets, options, &report);
      mass = mass_of(solid);
      bar.show_part(0.3, 0.8);
      if (writer) writer->write(solid, options, report);
      if (boxes_file)
        write_boxes(to_boxes(decompose(make_evm(solid, kAxisOrders[0]), BoxModel::cudb)),
                    std::move(*boxes_file));
    } else {
      mass = boxunion::measure(expression, sets, options, &report);
    }
    for (const Result& result : mass_results(mass)) results.push_back(result);
  });
  bar.clear();
  if (writer)
    for (const Result& result : writer->results())
      if (result.key != "vertices") results.push_back(result);  // already in the results
  if (!boxes.empty()) results.push_back(string_result("boxes_output", boxes));
  finish(results, {}, report, common);
  outputs.publish();
}

}  // namespace boxunion::command

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "boxunion/solid.hpp"
#include "host/command/command.hpp"
#include "host/command/command_output.hpp"
#include "host/external/external_boundary.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {

/// Writes the boundary of a union to a file, as vertices or as a mesh.
class BoundaryWriter {
 public:
  /// Opens the file, before the work that fills it.
  BoundaryWriter(const std::string& output, const BoundaryOptions& options, const Common& common,
                 OutputGroup& outputs);

  /// Writes the file, and adds the time to the report.
  void write(const Solid& solid, const Options& options, Report& report);
  /// The same for a union that does not fit memory.
  void write(ExternalUnion& solid, Report& report);
  /// The results: counts, as far as they are known or asked for, and the file. Warns of rounded coordinates
  /// and of shells that were not counted.
  std::vector<Result> results() const;

 private:
  std::string output_;
  NonManifold contacts_;
  bool triangles_, is_mesh_, has_faces_;
  OutputFile file_;
  ExternalBoundary written_;
};

}  // namespace boxunion::command

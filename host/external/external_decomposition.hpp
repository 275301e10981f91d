#pragma once

#include <cstdint>
#include <optional>

#include "boxunion/decomposition.hpp"
#include "boxunion/volume.hpp"
#include "core/models/sections.hpp"
#include "host/external/external_union.hpp"
#include "host/files/files.hpp"

namespace boxunion {

/// What was written.
struct ExternalModel {
  AxisOrder order{};
  std::uint64_t elements = 0;  ///< boxes or extreme vertices
  std::uint64_t pairs = 0;     ///< pairs of neighbors, if these were asked for
};

/// Makes the disjoint boxes of a solid that does not fit memory, or its extreme vertices if there is no
/// `model`. Writes them to `file`, if there is one, and commits it. The bytes are the same as from memory.
///
/// If no order is given, the first of those with the fewest elements is taken. Extreme vertices are sorted on
/// disk and swept; only a plane of them and the section behind it are in memory. If `connectivity` is given,
/// neighbors of boxes are counted like those of find_neighbors, by faces sorted on disk. Throws as
/// ExternalUnion::measure does, and Error(resources) that says how much memory it needs if a plane and a
/// section do not fit.
ExternalModel decompose(ExternalUnion& solid, std::optional<BoxModel> model,
                        const std::optional<AxisOrder>& order, std::optional<Connectivity> connectivity,
                        std::optional<OutputFile> file, Report& report);

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <optional>

#include "core/base/connectivity.hpp"
#include "core/models/decomposition.hpp"
#include "core/models/evm.hpp"
#include "host/external/external_union.hpp"
#include "host/files/files.hpp"

namespace boxunion {

/// What was made of a solid.
struct ExternalModel {
  AxisOrder order{};
  std::uint64_t elements = 0;  ///< boxes or extreme vertices
  std::uint64_t pairs = 0;     ///< of neighbors, if these were asked for
};

/// Makes the disjoint boxes of a solid that does not fit memory, or its extreme vertices if there is no
/// `model`, and writes and commits them to `file` if there is one: the same bytes as from memory.
///
/// The order is the given one, or that with the fewest elements, of equals the first. Extreme vertices are
/// sorted on disk and swept; in memory are only a plane of them and the section behind it. Neighbors of
/// boxes, where their `connectivity` is given, are counted as find_neighbors finds them, by faces sorted on
/// disk. Throws as ExternalUnion::measure does, and Error(resources), which says how much it takes, where a
/// plane and a section do not fit.
ExternalModel decompose(ExternalUnion& solid, std::optional<BoxModel> model,
                        const std::optional<AxisOrder>& order, std::optional<Connectivity> connectivity,
                        std::optional<OutputFile> file, Report& report);

}  // namespace boxunion

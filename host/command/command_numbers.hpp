#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>

// How the command line reads numbers. Each of these is passed to an option as `->transform(...)`. It replaces
// the text by plain digits, or rejects it with a message that says what was found and what is expected.

namespace boxunion::command {

/// A whole number from `least` to `most`, also written as 1e6 or 2.5e3.
CLI::Validator whole_number(std::uint64_t least = 0,
                            std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

/// A number of bytes, at least 1, also written with a unit: 512M, 1.5G, 2 GiB. Units are powers of 1024.
CLI::Validator byte_count();

/// A finite number.
CLI::Validator finite_number();

}  // namespace boxunion::command

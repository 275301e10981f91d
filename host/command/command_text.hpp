#pragma once

#include <string>
#include <string_view>

// How text of arbitrary bytes, such as names of files, is shown.

namespace boxunion::command {

/// Text for a terminal, on one line. Control characters and bytes that are not UTF-8 are escaped, as \n or
/// \x1b.
std::string printable(std::string_view text);

/// The same for several lines, which keep their line ends.
std::string printable_lines(std::string_view text);

/// A JSON string. Control characters are escaped. Each byte that is not UTF-8 becomes U+FFFD.
std::string json_string(std::string_view text);

}  // namespace boxunion::command

#pragma once

#include <string>
#include <string_view>

// How text of any bytes, as names of files are, is shown.

namespace boxunion::command {

/// Text for a terminal, on one line: control characters and bytes that are no UTF-8 are escaped, as \n or
/// \x1b.
std::string printable(std::string_view text);

/// The same for text of several lines, which keep their ends.
std::string printable_lines(std::string_view text);

/// A JSON string: control characters are escaped, each byte that is no UTF-8 becomes U+FFFD.
std::string json_string(std::string_view text);

}  // namespace boxunion::command

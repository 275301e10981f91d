#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "boxunion/error.hpp"

namespace boxunion {

/// Rounds coordinates to floats, for formats that have no doubles, and remembers whether any changed.
class FloatRounding {
 public:
  /// `path` begins the message of Error(input) for a coordinate beyond the range of floats.
  explicit FloatRounding(const std::string& path) : path_(path) {}

  float operator()(double coordinate) {
    const auto rounded = static_cast<float>(coordinate);
    if (std::isinf(rounded))
      throw Error(ErrorKind::input, fmt::format("{}: no float holds the coordinate {}", path_, coordinate));
    exact_ &= double(rounded) == coordinate;
    return rounded;
  }
  bool exact() const { return exact_; }

 private:
  const std::string& path_;
  bool exact_ = true;
};

}  // namespace boxunion

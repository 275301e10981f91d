#pragma once

#include <stdexcept>
#include <string>

#include "boxunion/export.hpp"

namespace boxunion {

/// What went wrong; the command line exits with the enumerator's value.
enum class ErrorKind {
  usage = 2,         ///< the caller asked for something that makes no sense
  input = 3,         ///< the boxes or the file are wrong
  device = 4,        ///< no such device, or it failed
  resources = 5,     ///< out of memory, or past a limit of the data structures
  interrupted = 130  ///< the caller asked to stop
};

/// The only exception that boxunion throws on purpose. `what()` is one sentence for the user.
class BOXUNION_API Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

}  // namespace boxunion

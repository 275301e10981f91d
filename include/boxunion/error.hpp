#pragma once

#include <stdexcept>
#include <string>

#include "boxunion/export.hpp"

namespace boxunion {

/// The kind of an error. The command line exits with its value.
enum class ErrorKind {
  usage = 2,         ///< the request makes no sense
  input = 3,         ///< the boxes or the file are wrong
  device = 4,        ///< there is no such device, or it failed
  resources = 5,     ///< out of memory, or beyond a limit of the data structures
  interrupted = 130  ///< the caller asked to stop
};

/// The exception that boxunion throws. what() is one sentence for the user.
class BOXUNION_API Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

}  // namespace boxunion

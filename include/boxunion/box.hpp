#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

/// The corner coordinates of an axis-aligned box: xmin, ymin, zmin, xmax, ymax, zmax, in the unit of the
/// caller.
template <class T>
using BoxOf = std::array<T, 6>;
using Box = BoxOf<double>;
using IntegerBox = BoxOf<std::int32_t>;

/// Any number of boxes in their original type: doubles, or 32-bit integers at half the memory.
///
/// A box is valid if all six numbers are finite and min <= max on every axis. A box with min == max on some
/// axis is degenerate: it is valid, is counted, and adds nothing to the (regularised) union.
class BOXUNION_API BoxSet {
 public:
  BoxSet() = default;
  BoxSet(std::vector<Box> boxes) : boxes_(std::move(boxes)) {}
  BoxSet(std::vector<IntegerBox> boxes) : boxes_(std::move(boxes)) {}

  /// Calls f with the vector of boxes, `std::vector<Box>` or `std::vector<IntegerBox>`.
  template <class F>
  decltype(auto) visit(F&& f) const {
    return std::visit(std::forward<F>(f), boxes_);
  }

  std::size_t size() const {
    return visit([](const auto& boxes) { return boxes.size(); });
  }
  /// Box i with its coordinates as doubles (exact for both types).
  Box operator[](std::size_t i) const;

 private:
  std::variant<std::vector<Box>, std::vector<IntegerBox>> boxes_;
};

/// True if all six numbers are finite, and min <= max on every axis.
BOXUNION_API bool is_valid(const Box& box);

/// Index of the first invalid box, or boxes.size() if all are valid. Parallel.
BOXUNION_API std::size_t find_invalid(const BoxSet& boxes);

/// Throws Error(input) that names the first invalid box ("box 17: ..."), counted from 1.
BOXUNION_API void validate(const BoxSet& boxes);

/// Throws Error(input) if `box` is invalid. The message begins with `name`, for example "row 17".
BOXUNION_API void validate(const Box& box, const std::string& name);

/// Number of boxes with min == max on some axis.
BOXUNION_API std::size_t count_degenerate(const BoxSet& boxes);

}  // namespace boxunion

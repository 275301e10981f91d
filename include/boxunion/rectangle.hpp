#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

/// The corner coordinates of an axis-aligned rectangle in the plane: xmin, ymin, xmax, ymax, in the unit of
/// the caller.
template <class T>
using RectangleOf = std::array<T, 4>;
using Rectangle = RectangleOf<double>;
using IntegerRectangle = RectangleOf<std::int32_t>;

/// Any number of rectangles in their original type: doubles, or 32-bit integers at half the memory. They are
/// valid or degenerate by the rules for boxes (box.hpp).
class RectangleSet {
 public:
  RectangleSet() = default;
  RectangleSet(std::vector<Rectangle> rectangles) : rectangles_(std::move(rectangles)) {}
  RectangleSet(std::vector<IntegerRectangle> rectangles) : rectangles_(std::move(rectangles)) {}

  /// Calls f with the vector of rectangles, `std::vector<Rectangle>` or `std::vector<IntegerRectangle>`.
  template <class F>
  decltype(auto) visit(F&& f) const {
    return std::visit(std::forward<F>(f), rectangles_);
  }

  std::size_t size() const {
    return visit([](const auto& rectangles) { return rectangles.size(); });
  }

 private:
  std::variant<std::vector<Rectangle>, std::vector<IntegerRectangle>> rectangles_;
};

/// Throws Error(input) that names the first invalid rectangle ("rectangle 17: ..."), counted from 1.
BOXUNION_API void validate(const RectangleSet& rectangles);

}  // namespace boxunion

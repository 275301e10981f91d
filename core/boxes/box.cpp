#include "boxunion/box.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "boxunion/error.hpp"
#include "core/base/parallel.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kCheckGrain = 1 << 16;
constexpr const char* kCoordinateNames[6] = {"xmin", "ymin", "zmin", "xmax", "ymax", "zmax"};

bool is_valid(const IntegerBox& box) {
  return box[0] <= box[3] && box[1] <= box[4] && box[2] <= box[5];
}

template <class T>
bool is_degenerate(const BoxOf<T>& box) {
  return box[0] == box[3] || box[1] == box[4] || box[2] == box[5];
}

}  // namespace

bool is_valid(const Box& box) {
  for (const double c : box)
    if (!std::isfinite(c)) return false;
  return box[0] <= box[3] && box[1] <= box[4] && box[2] <= box[5];
}

Box BoxSet::operator[](std::size_t i) const {
  return visit([i](const auto& boxes) {
    Box box;
    std::copy(boxes[i].begin(), boxes[i].end(), box.begin());
    return box;
  });
}

std::size_t find_invalid(const BoxSet& set) {
  return set.visit([](const auto& boxes) {
    const auto first_in_range = [&](std::size_t begin, std::size_t end, std::size_t first) {
      for (std::size_t i = begin; i < std::min(end, first); ++i)
        if (!is_valid(boxes[i])) return i;
      return first;
    };
    return parallel_reduce(0, boxes.size(), kCheckGrain, boxes.size(), first_in_range,
                           [](std::size_t a, std::size_t b) { return std::min(a, b); });
  });
}

void validate(const BoxSet& boxes) {
  const std::size_t i = find_invalid(boxes);
  if (i < boxes.size()) validate(boxes[i], fmt::format("box {}", i + 1));
}

void validate(const Box& box, const std::string& name) {
  if (is_valid(box)) return;
  for (std::size_t c = 0; c < 6; ++c)
    if (!std::isfinite(box[c]))
      throw Error(ErrorKind::input,
                  fmt::format("{}: {} is {}, expected a finite number", name, kCoordinateNames[c], box[c]));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (box[axis] > box[axis + 3])
      throw Error(ErrorKind::input,
                  fmt::format("{0}: {1} is {3} and {2} is {4}, expected {1} <= {2}", name,
                              kCoordinateNames[axis], kCoordinateNames[axis + 3], box[axis], box[axis + 3]));
}

std::size_t count_degenerate(const BoxSet& set) {
  return set.visit([](const auto& boxes) {
    const auto count_range = [&](std::size_t begin, std::size_t end, std::size_t count) {
      for (std::size_t i = begin; i < end; ++i) count += is_degenerate(boxes[i]);
      return count;
    };
    return parallel_reduce(0, boxes.size(), kCheckGrain, std::size_t{0}, count_range, std::plus<>());
  });
}

}  // namespace boxunion

#pragma once

#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "boxunion/box.hpp"

namespace boxunion {

/// Up to `most` boxes whose coordinates all come from a pool of at most `distinct`, so that faces often
/// coincide and some boxes are degenerate.
template <class T>
rc::Gen<std::vector<BoxOf<T>>> boxes_from(rc::Gen<T> coordinate, std::size_t distinct = 6,
                                          std::size_t most = 7) {
  const auto boxes_of_pool = [most](const std::vector<T>& pool) {
    const auto box =
        rc::gen::map(rc::gen::container<BoxOf<T>>(rc::gen::elementOf(pool)), [](BoxOf<T> corners) {
          for (unsigned axis = 0; axis < 3; ++axis)
            if (corners[axis] > corners[axis + 3]) std::swap(corners[axis], corners[axis + 3]);
          return corners;
        });
    return rc::gen::mapcat(rc::gen::inRange<std::size_t>(0, most + 1), [box](std::size_t count) {
      return rc::gen::container<std::vector<BoxOf<T>>>(count, box);
    });
  };
  const auto pool = rc::gen::mapcat(rc::gen::inRange<std::size_t>(1, distinct + 1), [=](std::size_t count) {
    return rc::gen::container<std::vector<T>>(count, coordinate);
  });
  // RapidCheck's sizes grow from case to case; here every case may use the whole range.
  return rc::gen::resize(rc::kNominalSize, rc::gen::mapcat(pool, boxes_of_pool));
}

/// Small integers as doubles.
inline rc::Gen<double> small_integer() {
  return rc::gen::map(rc::gen::inRange(-4, 5), [](int i) { return double(i); });
}

/// Coordinates of every size and sign that a double can hold, including subnormal ones.
inline rc::Gen<double> nasty_coordinate() {
  return rc::gen::element(0.0, -0.0, 5e-324, -5e-324, 1e-310, 2.2250738585072014e-308, 1e-300, -1e-300,
                          3e-100, 0.1, -0.3, 1.0, 1 / 3., 1.0000000000000002, 1e15 + 0.1, -1e15 - 0.3,
                          4503599627370497.5, 1e22, 1e100, 1e300, -1e300, 1.7976931348623157e308,
                          -1.7976931348623157e308);
}

/// Coordinates as in files: decimal fractions of moderate size.
inline rc::Gen<double> decimal() {
  return rc::gen::map(rc::gen::inRange(-2000, 2000), [](int i) { return i * 0.005; });
}

/// A unit cube for every set bit of the occupancy of an nx x ny x nz grid, x first.
inline std::vector<IntegerBox> unit_cubes(std::uint64_t occupancy, int nx, int ny, int nz) {
  std::vector<IntegerBox> boxes;
  for (int z = 0, i = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x, ++i)
        if (occupancy >> i & 1) boxes.push_back({x, y, z, x + 1, y + 1, z + 1});
  return boxes;
}

}  // namespace boxunion

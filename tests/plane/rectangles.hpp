#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <type_traits>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/rectangle.hpp"
#include "tests/support/generators.hpp"

namespace boxunion {

template <class T>
using Rectangles = std::vector<RectangleOf<T>>;

/// Up to `most` rectangles with coordinates from a pool of at most `distinct`; see boxes_from.
template <class T>
rc::Gen<Rectangles<T>> rectangles_from(rc::Gen<T> coordinate, std::size_t distinct = 8,
                                       std::size_t most = 12) {
  return rc::gen::map(boxes_from<T>(coordinate, distinct, most), [](const std::vector<BoxOf<T>>& boxes) {
    Rectangles<T> rectangles;
    for (const BoxOf<T>& b : boxes) rectangles.push_back({b[0], b[1], b[3], b[4]});
    return rectangles;
  });
}

/// Boxes of height 1 over the rectangles, from z = 0.
template <class T>
std::vector<BoxOf<T>> unit_boxes(const Rectangles<T>& rectangles) {
  std::vector<BoxOf<T>> boxes;
  for (const auto& r : rectangles) boxes.push_back({r[0], r[1], 0, r[2], r[3], 1});
  return boxes;
}

/// A unit square for every set bit of the occupancy of a grid with `columns` columns, x first.
inline Rectangles<std::int32_t> unit_squares(unsigned occupancy, int columns) {
  Rectangles<std::int32_t> squares;
  for (int i = 0; occupancy >> i != 0; ++i) {
    const int x = i % columns, y = i / columns;
    if (occupancy >> i & 1u) squares.push_back({x, y, x + 1, y + 1});
  }
  return squares;
}

/// Rectangles with sides up to width and height, and low corners in a square of side `extent`.
template <class T>
Rectangles<T> scattered(std::size_t count, double extent, double width, double height, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto coordinate = [](double x) { return T(std::is_integral_v<T> ? std::floor(x) : x); };
  Rectangles<T> result(count);
  for (auto& r : result) {
    const double x = unit(random) * extent, y = unit(random) * extent;
    r = {coordinate(x), coordinate(y), coordinate(x + unit(random) * width),
         coordinate(y + unit(random) * height)};
  }
  return result;
}

template <class T>
void append(Rectangles<T>& to, const Rectangles<T>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// Sets of some thousand rectangles, each of another kind.
template <class T>
std::vector<Rectangles<T>> large_sets() {
  constexpr double kWide = 2e9;
  std::vector<Rectangles<T>> sets;
  for (const double side : {40., 400., 3000.}) {
    sets.push_back(scattered<T>(4000, 20000, side, side, 1));
    sets.push_back(scattered<T>(4000, kWide / 2, side * kWide / 40000, side * kWide / 40000, 2));
  }
  sets.push_back(scattered<T>(20000, 300, 9, 9, 3));    // denser than its lattice
  sets.push_back(scattered<T>(300, 4000, 4000, 2, 4));  // crossing wires
  append(sets.back(), scattered<T>(300, 4000, 2, 4000, 5));
  sets.push_back(scattered<T>(3000, 500, 5, 5, 6));  // a crowd, and a few that extend the plane
  append(sets.back(), scattered<T>(20, kWide / 2, 100, 100, 7));
  sets.push_back(scattered<T>(20000, 30000, 9000, 9000, 11));  // many around each point
  sets.push_back(scattered<T>(3000, 30000, 3, 60000, 12));     // walls
  sets.push_back(Rectangles<T>(5000, {1, 1, 1000, 1000}));     // copies
  append(sets.back(), scattered<T>(50, 1000000, 100000, 100000, 8));
  Rectangles<T> nested;  // all share a corner
  for (int i = 1; i <= 3000; ++i) nested.push_back({0, 0, T(7 * i), T(100000 - 11 * i)});
  sets.push_back(nested);
  return sets;
}

}  // namespace boxunion

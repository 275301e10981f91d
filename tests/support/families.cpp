#include "tests/support/families.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "boxunion/generate.hpp"

namespace boxunion {
namespace {

using Boxes = std::vector<IntegerBox>;

constexpr int kUniverse = 1 << 20;

/// Random numbers that are the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// 0 .. limit - 1
  int below(std::int64_t limit) { return int(engine_() % std::uint64_t(limit)); }
  /// low .. high
  int between(int low, int high) { return low + below(std::int64_t{high} - low + 1); }
  /// 0 <= value < 1
  double fraction() { return double(engine_() >> 11) * 0x1p-53; }
  /// A random point of the simplex: three numbers that are at least 0 and sum to 1.
  std::array<double, 3> simplex() {
    double a = fraction(), b = fraction();
    if (a > b) std::swap(a, b);
    return {a, b - a, 1 - b};
  }

 private:
  std::mt19937_64 engine_;
};

/// The integer part of a root.
int root(double value, int degree) {
  auto r = int(degree == 2 ? std::sqrt(value) : std::cbrt(value));
  const auto power = [&](int base) { return degree == 2 ? 1.0 * base * base : 1.0 * base * base * base; };
  while (power(r + 1) <= value) ++r;
  while (r > 1 && power(r) > value) --r;
  return std::max(r, 1);
}
int root(std::size_t value, int degree) {
  return root(double(value), degree);
}

/// The number of groups of `boxes` boxes, at least one.
int groups(std::size_t size, std::size_t boxes) {
  return int(std::max(size / boxes, std::size_t{1}));
}

/// A box of thickness 1 along `axis`, with the given ends on the two other axes.
IntegerBox plate(std::size_t axis, int at, const std::array<int, 2>& lo, const std::array<int, 2>& hi) {
  IntegerBox box;
  box[axis] = at, box[axis + 3] = at + 1;
  for (std::size_t i = 0, a = 0; a < 3; ++a)
    if (a != axis) box[a] = lo[i], box[a + 3] = hi[i], ++i;
  return box;
}

/// `count` boxes. f(i) makes box i.
template <class F>
BoxSet make(std::size_t count, F f) {
  Boxes boxes(std::max(count, std::size_t{1}));
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes[i] = f(int(i));
  return boxes;
}

/// A box with these edges at a random place in [0, range]^3.
IntegerBox place(Random& random, int range, const std::array<int, 3>& edge) {
  IntegerBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    box[a] = random.below(std::max(range - edge[a], 0) + 1);
    box[a + 3] = box[a] + edge[a];
  }
  return box;
}

// ---- nested and stepped ----

BoxSet nested_shells(std::size_t size) {
  const int shells = groups(size, 6);
  Boxes boxes;
  for (int i = 0; i < shells; ++i) {
    const int l = 2 * i, h = 4 * shells - l;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int at : {l, h - 1}) boxes.push_back(plate(axis, at, {l, l}, {h, h}));
  }
  return boxes;
}

BoxSet holed_shells(std::size_t size) {
  const int shells = groups(size, 24);
  Boxes boxes;
  for (int i = 0; i < shells; ++i) {
    const int l = 2 * i, h = 4 * shells - l, a = l + shells - i, b = h - (shells - i);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int at : {l, h - 1}) {
        boxes.push_back(plate(axis, at, {l, l}, {a, h}));
        boxes.push_back(plate(axis, at, {b, l}, {h, h}));
        boxes.push_back(plate(axis, at, {a, l}, {b, a}));
        boxes.push_back(plate(axis, at, {a, b}, {b, h}));
      }
  }
  return boxes;
}

BoxSet square_rings(std::size_t size) {
  const int rings = groups(size, 4);
  Boxes boxes;
  for (int i = 0; i < rings; ++i) {
    const int l = 2 * i, h = 4 * rings - l;
    boxes.insert(
        boxes.end(),
        {{l, l, 0, l + 1, h, 1}, {h - 1, l, 0, h, h, 1}, {l, l, 0, h, l + 1, 1}, {l, h - 1, 0, h, h, 1}});
  }
  return boxes;
}

BoxSet staircase(std::size_t size) {
  return make(size, [n = int(size)](int i) { return IntegerBox{0, 0, 0, n - i, n, i + 1}; });
}

BoxSet ziggurat(std::size_t size) {
  return make(size, [n = int(size)](int i) { return IntegerBox{i, i, 0, 2 * n - i, 2 * n - i, i + 1}; });
}

// ---- long and thin ----

BoxSet wide_plates(std::size_t size) {
  const int side = root(std::max(size / 4, std::size_t{1}), 2);
  const auto length = int(std::int64_t{side} * (1 << 19) - 4 * std::int64_t(size));
  return make(size, [=, random = Random(1)](int i) mutable {
    const int x = random.below(1000), y = random.below(1000);
    return IntegerBox{x, y, 2 * i, length - random.below(1000), length - random.below(1000), 2 * i + 1};
  });
}

BoxSet jittered(std::size_t size, std::size_t normal) {
  return make(size, [=, random = Random(1)](int i) mutable {
    const auto end = [&] { return random.below(1000); };
    return plate(normal, 2 * i, {end(), end()}, {100'000 - end(), 100'000 - end()});
  });
}
BoxSet jittered_plates(std::size_t size) {
  return jittered(size, 2);
}
BoxSet jittered_walls(std::size_t size) {
  return jittered(size, 0);
}

BoxSet slabs(std::size_t size) {
  return make(size, [](int i) { return plate(2, 2 * i, {0, 0}, {kUniverse, kUniverse}); });
}

BoxSet long_rods(std::size_t size) {
  return make(size, [](int i) { return IntegerBox{i, i, 0, i + 1, i + 1, 1'000'000'000}; });
}

BoxSet needles(std::size_t size) {
  return make(size, [random = Random(3)](int i) mutable {
    IntegerBox box = place(random, kUniverse, {1, 1, 1});
    box[std::size_t(i % 3)] = 0, box[std::size_t(i % 3 + 3)] = kUniverse;
    return box;
  });
}

BoxSet sheets(std::size_t size) {
  const int edge = kUniverse / root(size, 3);
  return make(size, [=, random = Random(4)](int i) mutable {
    std::array<int, 3> edges{edge, edge, edge};
    edges[std::size_t(i % 3)] = 1;
    return place(random, kUniverse, edges);
  });
}

BoxSet jacks(std::size_t size) {
  const int count = groups(size, 3), edge = kUniverse / root(std::size_t(count), 3);
  Random random(5);
  Boxes boxes;
  for (int i = 0; i < count; ++i) {
    const IntegerBox center = place(random, kUniverse, {2, 2, 2});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      boxes.push_back(center);
      boxes.back()[axis] -= edge / 2, boxes.back()[axis + 3] += edge / 2;
    }
  }
  return boxes;
}

BoxSet combs(std::size_t size) {
  const int teeth = root(std::max(size / 2, std::size_t{1}), 2),
            pairs = groups(size, 2 * std::size_t(teeth + 1));
  const int length = 4 * teeth;
  Boxes boxes;
  for (int z = 0; z < 2 * pairs; z += 2) {
    boxes.push_back({0, 0, z, length, 1, z + 1});
    boxes.push_back({0, length + 2, z, length, length + 3, z + 1});
    for (int x = 0; x < length; x += 4) {
      boxes.push_back({x, 1, z, x + 1, length + 1, z + 1});
      boxes.push_back({x + 2, 2, z, x + 3, length + 2, z + 1});
    }
  }
  return boxes;
}

BoxSet woodpile(std::size_t size) {
  constexpr int kRods = 8;
  return make(size, [](int i) {
    const int z = i / kRods, at = 2 * (i % kRods);
    return z % 2 == 0 ? IntegerBox{at, 0, z, at + 1, 2 * kRods, z + 1}
                      : IntegerBox{0, at, z, 2 * kRods, at + 1, z + 1};
  });
}

// ---- many vertices ----

BoxSet grating(std::size_t size) {
  const int bars = root(std::max(size / 8, std::size_t{1}), 2);
  Boxes boxes;
  for (int i = 0; i < 2 * bars; i += 2) {
    boxes.push_back({i, 0, 0, i + 1, 2 * bars, 1});
    boxes.push_back({0, i, 0, 2 * bars, i + 1, 1});
  }
  return boxes;
}

BoxSet klee_slabs(std::size_t size) {
  const int count = root(std::max(size / 8, std::size_t{1}), 3);
  Boxes boxes;
  for (int i = 0; i < 2 * count; i += 2)
    for (std::size_t axis = 0; axis < 3; ++axis)
      boxes.push_back(plate(axis, i, {0, 0}, {2 * count, 2 * count}));
  return boxes;
}

BoxSet checkerboard(std::size_t size) {
  return collect(generate_checkerboard(root(2 * size, 3)));
}

BoxSet terrain(std::size_t size) {
  const int side = root(size, 2);
  return make(std::size_t(side) * std::size_t(side), [=, random = Random(6)](int i) mutable {
    const int x = i % side, y = i / side;
    return IntegerBox{x, y, 0, x + 1, y + 1, random.between(1, side)};
  });
}

// ---- deep overlap ----

BoxSet anchored(std::size_t size) {
  Random random(1);
  std::vector<Box> boxes(size);
  for (Box& box : boxes) {
    const auto [x, y, z] = random.simplex();
    box = {x, y, z, 1, 1, 1};
  }
  return boxes;
}

BoxSet orthants(std::size_t size) {
  return make(size, [random = Random(7)](int i) mutable {
    const std::array<double, 3> edges = random.simplex();
    IntegerBox box;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto edge = int(edges[a] * kUniverse);
      const bool high = (i >> a & 1) != 0;
      box[a] = high ? kUniverse - edge : 0;
      box[a + 3] = high ? kUniverse : edge;
    }
    return box;
  });
}

BoxSet columns(std::size_t size) {
  const int height = std::max(kUniverse / root(size, 2), 1);
  return make(size, [=, random = Random(8)](int) mutable {
    const int x = random.between(1, kUniverse - 1), z = random.below(kUniverse);
    return IntegerBox{0, 0, z, x, kUniverse - x, z + random.between(1, height)};
  });
}

BoxSet random_large(std::size_t size) {
  return make(size, [random = Random(9)](int) mutable {
    const auto edge = [&] { return random.between(kUniverse / 4, 3 * (kUniverse / 4)); };
    return place(random, kUniverse, {edge(), edge(), edge()});
  });
}

BoxSet duplicates(std::size_t size) {
  Random random(10);
  std::array<IntegerBox, 64> distinct;
  for (IntegerBox& box : distinct) box = place(random, 1000, {200, 200, 200});
  return make(size, [&](int) { return distinct[std::size_t(random.below(64))]; });
}

// ---- sizes and places ----

BoxSet cubes(std::size_t size) {
  const int edge = std::max(1, int(kUniverse * std::cbrt(0.5 / double(size))));
  return make(size, [=, random = Random(11)](int) mutable {
    return place(random, kUniverse, {edge, edge, edge});
  });
}

BoxSet crowded_plane(std::size_t size) {
  const int edge = kUniverse / root(size, 2);
  return make(size, [=, random = Random(12)](int i) mutable {
    IntegerBox box = place(random, kUniverse, {edge, edge, 0});
    box[2] = i % 3 == 0 ? 0 : -random.between(1, edge);
    box[5] = i % 3 == 1 ? 0 : random.between(1, edge);
    return box;
  });
}

BoxSet scales(std::size_t size) {
  constexpr int kScales = 24;
  const std::int64_t spread = 4 * root(size / kScales + 1, 3);
  return make(size, [=, random = Random(13)](int i) mutable {
    const int edge = 1 << i % kScales;
    return place(random, int(std::min(spread * edge, std::int64_t{1} << 30)), {edge, edge, edge});
  });
}

BoxSet all_scales(std::size_t size) {
  const double spread = 4 * root(size / 25 + 1, 3);
  Random random(14);
  std::vector<Box> boxes(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double unit = std::ldexp(1.0, 25 * (int(i % 25) - 12));
    for (std::size_t a = 0; a < 3; ++a) {
      boxes[i][a] = unit * spread * random.fraction();
      boxes[i][a + 3] = boxes[i][a] + unit * (0.5 + random.fraction());
    }
  }
  return boxes;
}

BoxSet archipelago(std::size_t size) {
  constexpr std::size_t kIslands = 64;
  const int range = 16 * root(size / kIslands + 1, 3);
  Random random(15);
  std::array<IntegerBox, kIslands> islands;
  for (IntegerBox& island : islands) island = place(random, 1 << 30, {range, range, range});
  return make(size, [&](int) {
    const IntegerBox& island = islands[std::size_t(random.below(kIslands))];
    IntegerBox box = place(random, range, {16, 16, 16});
    for (std::size_t c = 0; c < 6; ++c) box[c] += island[c % 3];
    return box;
  });
}

BoxSet outlier(std::size_t size) {
  const int range = 6 * root(size, 3) + 4;
  return make(size, [=, random = Random(16)](int i) mutable {
    if (i == 0) return IntegerBox{1 << 30, 1 << 30, 1 << 30, (1 << 30) + 1, (1 << 30) + 1, (1 << 30) + 1};
    return place(random, range, {4, 4, 4});
  });
}

constexpr Family kFamilies[] = {
    {"nested_shells", "hollow cubes of six plates, one inside the other", nested_shells},
    {"wide_plates", "disjoint plates across a universe of very many tiles", wide_plates},
    {"long_rods", "rods along a diagonal, 10^9 long", long_rods},
    {"jittered_plates", "disjoint plates normal to z whose ends differ a little", jittered_plates},
    {"jittered_walls", "disjoint plates normal to x whose ends differ a little", jittered_walls},
    {"square_rings", "rings of four rods, one inside the other, in a plane", square_rings},
    {"needles", "rods of width 1 at random places across the universe", needles},
    {"anchored", "boxes with a common corner, none inside another: a front of points (doubles)", anchored},
    {"orthants", "the same from all eight corners of the universe", orthants},
    {"columns", "boxes with a common edge, at random heights", columns},
    {"staircase", "steps that lie over each other down to a common edge", staircase},
    {"ziggurat", "square terraces that lie over each other, smaller to the top", ziggurat},
    {"combs", "pairs of combs with their teeth between each other's", combs},
    {"woodpile", "layers of eight rods, crosswise", woodpile},
    {"grating", "bars along x across bars along y; sized by vertices", grating},
    {"klee_slabs", "slabs along all three axes; sized by vertices", klee_slabs},
    {"checkerboard", "cubes that touch along edges", checkerboard},
    {"terrain", "touching columns of random height", terrain},
    {"holed_shells", "nested shells with a window in every face", holed_shells},
    {"slabs", "equal plates, one above the other", slabs},
    {"sheets", "thin squares in all directions that cross a few others", sheets},
    {"jacks", "crosses of three bars at random places", jacks},
    {"cubes", "random cubes with a sum of volumes of half the universe", cubes},
    {"random_large", "random boxes of about half the universe", random_large},
    {"duplicates", "64 cubes, each very often", duplicates},
    {"crowded_plane", "boxes on, under and through one plane", crowded_plane},
    {"scales", "cubes of edges 1 to 2^23", scales},
    {"all_scales", "boxes of edges 2^-300 to 2^300 (doubles)", all_scales},
    {"archipelago", "64 dense clusters far from each other", archipelago},
    {"outlier", "dense cubes, and one far from them", outlier},
};

}  // namespace

std::span<const Family> families() {
  return kFamilies;
}

const char* name(RowOrder order) {
  constexpr std::array kNames = {"given", "reversed", "shuffled"};
  return kNames[std::size_t(order)];
}

BoxSet reorder(const BoxSet& boxes, RowOrder order) {
  return boxes.visit([&]<class T>(std::vector<BoxOf<T>> rows) -> BoxSet {
    if (order == RowOrder::reversed) std::ranges::reverse(rows);
    if (order == RowOrder::shuffled) {
      std::mt19937_64 random(17);
      for (std::size_t i = rows.size(); i > 1; --i) std::swap(rows[i - 1], rows[random() % i]);
    }
    return rows;
  });
}

}  // namespace boxunion

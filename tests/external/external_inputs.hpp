#pragma once

#include <cmath>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "boxunion/box.hpp"
#include "boxunion/generate.hpp"

namespace boxunion {

/// Boxes that are united in slabs.
struct Input {
  std::string name;
  BoxSet boxes;
};

/// Random boxes of all kinds. The seed is printed.
inline std::vector<Input> external_inputs() {
  const std::uint64_t seed = std::random_device{}();
  std::cout << "seed " << seed << '\n';
  std::mt19937_64 random(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution(lo, hi)(random); };
  std::vector<Box> doubles, clustered, one_plane, mixed;
  for (int i = 0; i < 3000; ++i) {
    const auto add = [&](std::vector<Box>& boxes, double x, double y, double z, double edge) {
      boxes.push_back({x, y, z, x + uniform(0, edge), y + uniform(0, edge), z + uniform(0, edge)});
    };
    add(doubles, uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), 0.1);
    const double scale = std::exp(uniform(-20, 0));
    add(clustered, scale * uniform(0, 1), scale * uniform(0, 1), scale * uniform(0, 1), scale);
    add(one_plane, uniform(0, 1), uniform(0, 1), 0, 0.03);
    one_plane.back()[5] = 1;
    add(mixed, std::floor(uniform(0, 300)), uniform(0, 1), std::floor(uniform(0, 300)), 0.1);
    for (const int c : {3, 5}) mixed.back()[std::size_t(c)] = mixed.back()[std::size_t(c - 3)] + 7;
  }
  doubles.push_back({0, 0, 0, 0, 1, 1});  // degenerate
  std::vector<IntegerBox> touching;
  for (int i = 0; i < 4000; ++i) {
    const auto at = [&] { return int(random() % 15); };
    const int x = at(), y = at(), z = at();
    touching.push_back({x, y, z, x + 1, y + 1, z + int(random() % 3)});
  }
  return {{"sparse", collect(generate_cubes(4000, 300, 32768, seed))},
          {"dense", collect(generate_boxes(3000, 0, 40, 200, seed))},
          {"wide", collect(generate_boxes(2000, 1, 1 << 28, (1ll << 31) - 1, seed))},
          {"large", collect(generate_boxes(500, 1, 9000, 10'000, seed))},
          {"touching", touching},
          {"checkerboard", collect(generate_checkerboard(16))},
          {"sponge", collect(generate_sponge(3))},
          {"doubles", doubles},
          {"clustered", clustered},
          {"one plane", one_plane},
          {"mixed", mixed},
          {"degenerate", std::vector<IntegerBox>(100, IntegerBox{1, 2, 3, 1, 4, 5})},
          {"none", std::vector<Box>()}};
}

}  // namespace boxunion

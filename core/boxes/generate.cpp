#include "boxunion/generate.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <random>
#include <string_view>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBlock = 1 << 16;

void check_range(std::string_view name, std::int64_t value, std::int64_t min, std::int64_t max) {
  if (value < min || value > max)
    throw Error(ErrorKind::usage, fmt::format("{} is {}, expected {} to {}", name, value, min, max));
}

void check_universe(std::int64_t universe) {
  check_range("universe", universe, 1, std::numeric_limits<std::int32_t>::max());
}

/// Passes boxes on in blocks.
class Blocks {
 public:
  explicit Blocks(const BoxBlockSink& sink) : sink_(sink) { block_.reserve(kBlock); }
  void add(const IntegerBox& box) {
    block_.push_back(box);
    if (block_.size() == kBlock) flush();
  }
  void flush() {
    if (!block_.empty()) sink_(block_);
    block_.clear();
  }

 private:
  const BoxBlockSink& sink_;
  std::vector<IntegerBox> block_;
};

/// next_box(i) makes box i. It is called in order, on a new copy for each run, so that every run starts
/// afresh.
template <class F>
BoxGenerator make_generator(std::uint64_t count, F next_box) {
  return {count, [=](const BoxBlockSink& sink) {
            F fresh = next_box;
            Blocks blocks(sink);
            for (std::uint64_t i = 0; i < count; ++i) blocks.add(fresh(i));
            blocks.flush();
          }};
}

IntegerBox unit_cube(std::int32_t x, std::int32_t y, std::int32_t z) {
  return {x, y, z, x + 1, y + 1, z + 1};
}

/// The 20 subcubes of one level of the Menger sponge: in each, at most one coordinate is the middle one.
constexpr std::array<std::array<std::int32_t, 3>, 20> sponge_cells() {
  std::array<std::array<std::int32_t, 3>, 20> cells{};
  std::size_t n = 0;
  for (std::int32_t z = 0; z < 3; ++z)
    for (std::int32_t y = 0; y < 3; ++y)
      for (std::int32_t x = 0; x < 3; ++x)
        if ((x == 1) + (y == 1) + (z == 1) < 2) cells[n++] = {x, y, z};
  return cells;
}

}  // namespace

BoxGenerator generate_cubes(std::uint64_t count, std::int64_t edge, std::int64_t universe,
                            std::uint64_t seed) {
  check_universe(universe);
  check_range("edge", edge, 1, universe);
  const auto side = std::int32_t(edge);
  const auto positions = std::uint64_t(universe - edge + 1);
  return make_generator(count, [=, random = std::mt19937_64(seed)](std::uint64_t) mutable {
    const auto x = std::int32_t(random() % positions);
    const auto y = std::int32_t(random() % positions);
    const auto z = std::int32_t(random() % positions);
    return IntegerBox{x, y, z, x + side, y + side, z + side};
  });
}

BoxGenerator generate_boxes(std::uint64_t count, std::int64_t min_edge, std::int64_t max_edge,
                            std::int64_t universe, std::uint64_t seed) {
  check_universe(universe);
  check_range("max edge", max_edge, 0, universe);
  check_range("min edge", min_edge, 0, max_edge);
  const auto edges = std::uint64_t(max_edge - min_edge + 1);
  return make_generator(count, [=, random = std::mt19937_64(seed)](std::uint64_t) mutable {
    IntegerBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t edge = min_edge + std::int64_t(random() % edges);
      const auto low = std::int64_t(random() % std::uint64_t(universe - edge + 1));
      box[axis] = std::int32_t(low);
      box[axis + 3] = std::int32_t(low + edge);
    }
    return box;
  });
}

BoxGenerator generate_checkerboard(std::int64_t size) {
  check_range("size", size, 1, 2'000'000);
  const auto n = std::int32_t(size);
  const auto cells = std::uint64_t(size) * std::uint64_t(size) * std::uint64_t(size);
  return {(cells + 1) / 2, [n](const BoxBlockSink& sink) {
            Blocks blocks(sink);
            for (std::int32_t z = 0; z < n; ++z)
              for (std::int32_t y = 0; y < n; ++y)
                for (std::int32_t x = (y + z) % 2; x < n; x += 2) blocks.add(unit_cube(x, y, z));
            blocks.flush();
          }};
}

BoxGenerator generate_sponge(int level) {
  check_range("level", level, 0, 14);
  std::uint64_t count = 1;
  for (int i = 0; i < level; ++i) count *= 20;
  return make_generator(count, [level](std::uint64_t i) {
    static constexpr auto kCells = sponge_cells();
    std::array<std::int32_t, 3> corner{};
    std::int32_t scale = 1;
    for (int digit = 0; digit < level; ++digit, scale *= 3, i /= 20)
      for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] += scale * kCells[i % 20][axis];
    return unit_cube(corner[0], corner[1], corner[2]);
  });
}

std::vector<IntegerBox> collect(const BoxGenerator& generator) {
  std::vector<IntegerBox> boxes;
  boxes.reserve(generator.count);
  generator.run(
      [&](std::span<const IntegerBox> block) { boxes.insert(boxes.end(), block.begin(), block.end()); });
  return boxes;
}

}  // namespace boxunion

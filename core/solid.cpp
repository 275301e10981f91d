#include "core/solid.hpp"

#include <bit>
#include <cstdint>
#include <utility>

#include "core/memory.hpp"
#include "core/radix_sort.hpp"

namespace boxunion {
namespace {

constexpr auto kWhat = "collecting the vertices";
constexpr std::size_t kGrain = 1 << 15;  // vertices

/// Vertices as numbers that sort as they do, where their bits are few enough.
class VertexCode {
 public:
  explicit VertexCode(const std::array<std::uint32_t, 3>& bits)
      : y_(kMaskBits + std::bit_width(bits[0])),
        z_(y_ + std::bit_width(bits[1])),
        fits_(z_ + std::bit_width(bits[2]) <= 64) {}

  bool fits() const { return fits_; }
  std::uint64_t encode(const Vertex& v) const {
    return std::uint64_t{v.z} << z_ | std::uint64_t{v.y} << y_ | std::uint64_t{v.x} << kMaskBits | v.mask;
  }
  Vertex decode(std::uint64_t code) const {
    const auto bits = [code](int from, int to) {
      return static_cast<std::uint32_t>(code >> from & ~(~std::uint64_t{0} << (to - from)));
    };
    return {bits(kMaskBits, y_), bits(y_, z_), static_cast<std::uint32_t>(code >> z_), bits(0, kMaskBits)};
  }

 private:
  static constexpr int kMaskBits = 8;
  int y_, z_;  // where ordinals begin
  bool fits_;
};

}  // namespace

void SolidSink::add(std::span<const Vertex> vertices) {
  Part& mine = parts_.local();
  mine.vertices.insert(mine.vertices.end(), vertices.begin(), vertices.end());
  for (const Vertex& v : vertices) {
    mine.bits[0] |= v.x;
    mine.bits[1] |= v.y;
    mine.bits[2] |= v.z;
  }
}

Solid SolidSink::take(Axes axes) {
  std::size_t count = 0;
  std::array<std::uint32_t, 3> bits{};
  parts_.for_each([&](const Part& part) {
    count += part.vertices.size();
    for (unsigned a = 0; a < 3; ++a) bits[a] |= part.bits[a];
  });
  // Puts all that was added in one array, each as convert(vertex).
  const auto collect = [&](auto&& convert) {
    auto all = make_array<decltype(convert(Vertex{}))>(count, kWhat);
    std::size_t first = 0;
    parts_.for_each([&](Part& part) {
      parallel_ranges(0, part.vertices.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) all[first + i] = convert(part.vertices[i]);
      });
      first += part.vertices.size();
      part = {};  // gives its memory back at once
    });
    return all;
  };
  Solid solid{std::move(axes), {}};
  if (const VertexCode code(bits); code.fits()) {
    Array<std::uint64_t> codes = collect([&](const Vertex& v) { return code.encode(v); });
    radix_sort(std::span(codes));
    solid.vertices = make_array<Vertex>(count, kWhat);
    parallel_ranges(0, count, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) solid.vertices[i] = code.decode(codes[i]);
    });
  } else {
    solid.vertices = collect([](const Vertex& v) { return v; });
    radix_sort(std::span(solid.vertices), [](const Vertex& v) {
      return static_cast<unsigned __int128>(v.z) << 64 | (std::uint64_t(v.y) << 32 | v.x);
    });
  }
  return solid;
}

}  // namespace boxunion

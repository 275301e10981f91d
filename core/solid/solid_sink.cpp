#include "core/solid/solid_sink.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/memory.hpp"
#include "core/base/radix_sort.hpp"

namespace boxunion {
namespace {

constexpr auto kWhat = "collecting the vertices";
constexpr std::size_t kVertexGrain = 1 << 15;  // vertices

/// Moves the lists of all parts into one array.
template <class Part, class T>
Array<T> collect(PerThread<Part>& parts, BlockList<T> Part::*list) {
  std::vector<std::pair<std::span<const T>, std::size_t>> blocks;  // with their places in the array
  std::size_t count = 0;
  parts.for_each([&](const Part& part) {
    for (const Array<T>& block : (part.*list).blocks()) {
      blocks.emplace_back(block, count);
      count += block.size();
    }
  });
  auto all = make_array<T>(count, kWhat);
  parallel_for_each(0, blocks.size(), 1, [&](std::size_t i) {
    std::copy(blocks[i].first.begin(), blocks[i].first.end(), all.begin() + std::ptrdiff_t(blocks[i].second));
  });
  parts.for_each([&](Part& part) { part.*list = {}; });
  return all;
}

}  // namespace

VertexCode::VertexCode(const Axes& axes)
    : y_(kMaskBits + std::bit_width(axes[0].count())),
      z_(y_ + std::bit_width(axes[1].count())),
      fits_(z_ + std::bit_width(axes[2].count()) <= 64) {}

void SolidSink::add(std::span<const Vertex> vertices) {
  Part& mine = parts_.local();
  const auto append = [&](auto& list, auto&& convert) {
    for (std::size_t done = 0; done < vertices.size();)
      for (auto& place : list.extend(vertices.size() - done)) place = convert(vertices[done++]);
  };
  if (code_.fits())
    append(mine.codes, [this](const Vertex& v) { return code_.encode(v); });
  else
    append(mine.vertices, [](const Vertex& v) { return v; });
}

Solid SolidSink::take() {
  Solid solid;
  if (code_.fits()) {
    Array<std::uint64_t> codes = collect(parts_, &Part::codes);
    radix_sort(std::span(codes));
    solid.vertices = make_array<Vertex>(codes.size(), kWhat);
    parallel_for_each(0, codes.size(), kVertexGrain,
                      [&](std::size_t i) { solid.vertices[i] = code_.decode(codes[i]); });
  } else {
    solid.vertices = collect(parts_, &Part::vertices);
    radix_sort(std::span(solid.vertices), [](const Vertex& v) {
      return static_cast<unsigned __int128>(v.z) << 64 | (std::uint64_t(v.y) << 32 | v.x);
    });
  }
  solid.axes = std::exchange(axes_, {});
  return solid;
}

}  // namespace boxunion

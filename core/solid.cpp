#include "core/solid.hpp"

#include <cstdint>
#include <utility>

#include "core/memory.hpp"
#include "core/radix_sort.hpp"

namespace boxunion {

void SolidSink::add(std::span<const Vertex> vertices) {
  std::vector<Vertex>& mine = vertices_.local();
  mine.insert(mine.end(), vertices.begin(), vertices.end());
}

Solid SolidSink::take(Axes axes) {
  std::size_t count = 0;
  vertices_.for_each([&](const std::vector<Vertex>& part) { count += part.size(); });
  Solid solid{std::move(axes), {}};
  with_memory("collecting the vertices", count * sizeof(Vertex), [&] { solid.vertices.reserve(count); });
  vertices_.for_each([&](std::vector<Vertex>& part) {
    solid.vertices.insert(solid.vertices.end(), part.begin(), part.end());
    part = {};  // gives its memory back at once
  });
  radix_sort(std::span(solid.vertices), [](const Vertex& v) {
    return static_cast<unsigned __int128>(v.z) << 64 | (std::uint64_t(v.y) << 32 | v.x);
  });
  return solid;
}

}  // namespace boxunion

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "host/files/floats.hpp"
#include "host/files/formats.hpp"

// PLY: http://paulbourke.net/dataformats/ply/ ; STL:
// https://en.wikipedia.org/wiki/STL_(file_format)#Binary_STL

namespace boxunion {
namespace {

static_assert(std::endian::native == std::endian::little, "the writers below copy numbers as they are");

/// Writes records of N bytes. fill(i, bytes) makes record i.
template <std::size_t N, class Fill>
void write_records(OutputFile& file, std::size_t count, Fill fill) {
  constexpr std::size_t kRecords = 1 << 14;
  std::vector<std::array<char, N>> records(std::min(count, kRecords));
  for (std::size_t first = 0; first < count; first += kRecords) {
    const std::size_t some = std::min(kRecords, count - first);
    for (std::size_t i = 0; i < some; ++i) fill(first + i, records[i].data());
    file.write_array(std::span<const std::array<char, N>>(records).first(some));
  }
}

}  // namespace

namespace ply {

void write_header(OutputFile& file, std::uint64_t points, std::uint64_t triangles) {
  file.write(
      fmt::format("ply\nformat binary_little_endian 1.0\ncomment boxunion\n"
                  "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
                  "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                  points, triangles));
}

void write_points(OutputFile& file, std::span<const Point> points) {
  write_records<sizeof(Point)>(file, points.size(), [&](std::size_t i, char* bytes) {
    std::memcpy(bytes, &points[i], sizeof(Point));
  });
}

void write_triangles(OutputFile& file, std::span<const Triangle> triangles) {
  write_records<1 + sizeof(Triangle)>(file, triangles.size(), [&](std::size_t i, char* bytes) {
    bytes[0] = 3;
    std::memcpy(bytes + 1, &triangles[i], sizeof(Triangle));
  });
}

}  // namespace ply

namespace stl {

void write_header(OutputFile& file, std::uint64_t triangles) {
  std::array<char, 80> header{};
  std::memcpy(header.data(), "boxunion", 8);
  file.write({header.data(), header.size()});
  const auto count = static_cast<std::uint32_t>(triangles);
  file.write_array(std::span(&count, 1));
}

bool write_triangles(OutputFile& file, std::span<const Point> points, const Faces& faces,
                     const Triangulation& triangulation) {
  FloatRounding round(file.path());
  std::size_t face = 0;
  write_records<50>(file, triangulation.triangles.size(), [&](std::size_t i, char* bytes) {
    while (triangulation.first[face + 1] <= i) ++face;
    const unsigned direction = faces.direction[face];
    std::array<float, 12> numbers{};  // normal and corners
    numbers[direction / 2] = direction % 2 == 0 ? 1.0f : -1.0f;
    for (std::size_t corner = 0; corner < 3; ++corner)
      for (std::size_t a = 0; a < 3; ++a)
        numbers[3 + 3 * corner + a] = round(points[triangulation.triangles[i][corner]][a]);
    std::memcpy(bytes, numbers.data(), sizeof numbers);
    bytes[48] = bytes[49] = 0;  // attributes
  });
  return round.exact();
}

}  // namespace stl
}  // namespace boxunion

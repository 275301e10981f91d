#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
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
namespace {

class Mesh final : public MeshWriter {
 public:
  Mesh(OutputFile& file, const MeshSize& size) : file_(file) {
    file_.write(
        fmt::format("ply\nformat binary_little_endian 1.0\ncomment boxunion\n"
                    "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
                    "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                    size.points, size.triangles));
  }
  void write_points(std::span<const Point> points) override {
    write_records<sizeof(Point)>(file_, points.size(), [&](std::size_t i, char* bytes) {
      std::memcpy(bytes, &points[i], sizeof(Point));
    });
  }
  void write_faces(std::span<const Point>, const Faces&, const Triangulation& triangulation) override {
    const std::span<const Triangle> triangles = triangulation.triangles;
    write_records<1 + sizeof(Triangle)>(file_, triangles.size(), [&](std::size_t i, char* bytes) {
      bytes[0] = 3;
      std::memcpy(bytes + 1, &triangles[i], sizeof(Triangle));
    });
  }

 private:
  OutputFile& file_;
};

}  // namespace

std::unique_ptr<MeshWriter> begin(OutputFile& file, const MeshSize& size) {
  return std::make_unique<Mesh>(file, size);
}

}  // namespace ply

namespace stl {
namespace {

class Mesh final : public MeshWriter {
 public:
  Mesh(OutputFile& file, const MeshSize& size) : file_(file) {
    std::array<char, 80> header{};
    std::memcpy(header.data(), "boxunion", 8);
    file_.write({header.data(), header.size()});
    const auto count = static_cast<std::uint32_t>(size.triangles);
    file_.write_array(std::span(&count, 1));
  }
  bool is_indexed() const override { return false; }
  void write_points(std::span<const Point>) override {}
  void write_faces(std::span<const Point> points, const Faces& faces,
                   const Triangulation& triangulation) override {
    FloatRounding round(file_.path());
    std::size_t face = 0;
    write_records<50>(file_, triangulation.triangles.size(), [&](std::size_t i, char* bytes) {
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
    exact_ &= round.exact();
  }
  bool exact() const override { return exact_; }

 private:
  OutputFile& file_;
  bool exact_ = true;
};

}  // namespace

std::unique_ptr<MeshWriter> begin(OutputFile& file, const MeshSize& size) {
  return std::make_unique<Mesh>(file, size);
}

}  // namespace stl
}  // namespace boxunion

#include <fmt/compile.h>
#include <fmt/format.h>

#include <iterator>

#include "host/files/formats.hpp"
#include "host/files/text_rows.hpp"

// OBJ: http://paulbourke.net/dataformats/obj/ ; OFF: http://www.geomview.org/docs/html/OFF.html

namespace boxunion {
namespace obj {
namespace {

class Mesh final : public MeshWriter {
 public:
  Mesh(OutputFile& file, const MeshSize& size) : file_(file), triangles_only_(size.triangles_only) {
    file_.write("# boxunion\n");
  }
  void write_points(std::span<const Point> points) override {
    write_rows(file_, points.size(), [&](std::size_t i, fmt::memory_buffer& text) {
      const Point& p = points[i];
      fmt::format_to(std::back_inserter(text), FMT_COMPILE("v {} {} {}\n"), p[0], p[1], p[2]);
    });
  }
  void write_faces(std::span<const Point>, const Faces& faces, const Triangulation& triangulation) override {
    write_rows(file_, faces.size(), [&](std::size_t f, fmt::memory_buffer& text) {
      if (!triangles_only_ && faces.holes(f) == 0)
        return write_polygon(faces.loop(faces.first_loop[f]), text);
      for (std::uint32_t t = triangulation.first[f]; t < triangulation.first[f + 1]; ++t)
        write_polygon(triangulation.triangles[t], text);
    });
  }

 private:
  static void write_polygon(std::span<const std::uint32_t> polygon, fmt::memory_buffer& text) {
    text.push_back('f');
    for (const std::uint32_t point : polygon) {
      const fmt::format_int number(point + std::uint64_t{1});
      text.push_back(' ');
      text.append(number.data(), number.data() + number.size());
    }
    text.push_back('\n');
  }

  OutputFile& file_;
  bool triangles_only_;
};

}  // namespace

std::unique_ptr<MeshWriter> begin(OutputFile& file, const MeshSize& size) {
  return std::make_unique<Mesh>(file, size);
}

}  // namespace obj

namespace off {
namespace {

class Mesh final : public MeshWriter {
 public:
  Mesh(OutputFile& file, const MeshSize& size) : file_(file) {
    file_.write(fmt::format("OFF\n{} {} 0\n", size.points, size.triangles));
  }
  void write_points(std::span<const Point> points) override {
    write_rows(file_, points.size(), [&](std::size_t i, fmt::memory_buffer& text) {
      fmt::format_to(std::back_inserter(text), FMT_COMPILE("{} {} {}\n"), points[i][0], points[i][1],
                     points[i][2]);
    });
  }
  void write_faces(std::span<const Point>, const Faces&, const Triangulation& triangulation) override {
    write_rows(file_, triangulation.triangles.size(), [&](std::size_t i, fmt::memory_buffer& text) {
      const Triangle& t = triangulation.triangles[i];
      fmt::format_to(std::back_inserter(text), FMT_COMPILE("3 {} {} {}\n"), t[0], t[1], t[2]);
    });
  }

 private:
  OutputFile& file_;
};

}  // namespace

std::unique_ptr<MeshWriter> begin(OutputFile& file, const MeshSize& size) {
  return std::make_unique<Mesh>(file, size);
}

}  // namespace off
}  // namespace boxunion

#include <fmt/compile.h>
#include <fmt/format.h>

#include <iterator>

#include "host/files/formats.hpp"
#include "host/files/text_rows.hpp"

// OBJ: http://paulbourke.net/dataformats/obj/ ; OFF: http://www.geomview.org/docs/html/OFF.html

namespace boxunion {
namespace obj {

void write_header(OutputFile& file) {
  file.write("# boxunion\n");
}

void write_points(OutputFile& file, std::span<const Point> points) {
  write_rows(file, points.size(), [&](std::size_t i, fmt::memory_buffer& text) {
    const Point& p = points[i];
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("v {} {} {}\n"), p[0], p[1], p[2]);
  });
}

void write_faces(OutputFile& file, const Faces& faces, const Triangulation& triangulation,
                 bool triangles_only) {
  const auto write_polygon = [](std::span<const std::uint32_t> polygon, fmt::memory_buffer& text) {
    text.push_back('f');
    for (const std::uint32_t point : polygon) {
      const fmt::format_int number(point + std::uint64_t{1});
      text.push_back(' ');
      text.append(number.data(), number.data() + number.size());
    }
    text.push_back('\n');
  };
  write_rows(file, faces.size(), [&](std::size_t f, fmt::memory_buffer& text) {
    if (!triangles_only && faces.holes(f) == 0) return write_polygon(faces.loop(faces.first_loop[f]), text);
    for (std::uint32_t t = triangulation.first[f]; t < triangulation.first[f + 1]; ++t)
      write_polygon(triangulation.triangles[t], text);
  });
}

}  // namespace obj

namespace off {

void write_header(OutputFile& file, std::uint64_t points, std::uint64_t triangles) {
  file.write(fmt::format("OFF\n{} {} 0\n", points, triangles));
}

void write_points(OutputFile& file, std::span<const Point> points) {
  write_rows(file, points.size(), [&](std::size_t i, fmt::memory_buffer& text) {
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{} {} {}\n"), points[i][0], points[i][1],
                   points[i][2]);
  });
}

void write_triangles(OutputFile& file, std::span<const Triangle> triangles) {
  write_rows(file, triangles.size(), [&](std::size_t i, fmt::memory_buffer& text) {
    const Triangle& t = triangles[i];
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("3 {} {} {}\n"), t[0], t[1], t[2]);
  });
}

}  // namespace off
}  // namespace boxunion

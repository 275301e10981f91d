#include <fmt/compile.h>
#include <fmt/format.h>

#include <iterator>
#include <memory>

#include "boxunion/error.hpp"
#include "host/files/formats.hpp"
#include "host/files/text_rows.hpp"
#include "host/files/zip.hpp"

// 3MF, core specification: https://github.com/3MFConsortium/spec_core

namespace boxunion::threemf {
namespace {

constexpr std::uint64_t kMost = 0x7fffffff;  // vertices or triangles of a mesh

constexpr std::string_view kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";
constexpr std::string_view kRelationships =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/>
</Relationships>
)";
constexpr std::string_view kModel =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<metadata name="Application">boxunion</metadata>
<resources>
)";

/// Writes a mesh as a package of one model: all points, then all triangles.
class Mesh final : public MeshWriter {
 public:
  Mesh(OutputFile& file, const MeshSize& size)
      : package_(file), points_left_(size.points), has_mesh_(size.triangles > 0) {
    if (size.points > kMost || size.triangles > kMost)
      throw Error(ErrorKind::resources,
                  fmt::format("{}: {} points and {} triangles, but 3MF holds fewer than 2^31 of each",
                              file.path(), size.points, size.triangles));
    package_.begin("[Content_Types].xml");
    package_.write(kContentTypes);
    package_.begin("_rels/.rels");
    package_.write(kRelationships);
    package_.begin("3D/3dmodel.model");
    package_.write(kModel);
    if (has_mesh_) package_.write("<object id=\"1\" type=\"model\"><mesh><vertices>\n");
  }
  void write_points(std::span<const Point> points) override {
    write_rows(package_, points.size(), [&](std::size_t i, fmt::memory_buffer& text) {
      const Point& p = points[i];
      fmt::format_to(std::back_inserter(text), FMT_COMPILE("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n"), p[0],
                     p[1], p[2]);
    });
    points_left_ -= points.size();
    if (!points.empty() && points_left_ == 0) package_.write("</vertices><triangles>\n");
  }
  void write_faces(std::span<const Point>, const Faces&, const Triangulation& triangulation) override {
    write_rows(package_, triangulation.triangles.size(), [&](std::size_t i, fmt::memory_buffer& text) {
      const Triangle& t = triangulation.triangles[i];
      fmt::format_to(std::back_inserter(text), FMT_COMPILE("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n"),
                     t[0], t[1], t[2]);
    });
  }
  void finish() override {
    if (has_mesh_) package_.write("</triangles></mesh></object>\n");
    package_.write("</resources>\n<build>\n");
    if (has_mesh_) package_.write("<item objectid=\"1\"/>\n");
    package_.write("</build>\n</model>\n");
    package_.finish();
  }

 private:
  ZipWriter package_;
  std::uint64_t points_left_;
  bool has_mesh_;  ///< a mesh without triangles would be none
};

}  // namespace

std::unique_ptr<MeshWriter> begin(OutputFile& file, const MeshSize& size) {
  return std::make_unique<Mesh>(file, size);
}

}  // namespace boxunion::threemf

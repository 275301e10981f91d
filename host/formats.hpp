#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/box.hpp"
#include "core/brep.hpp"
#include "core/components.hpp"
#include "core/evm.hpp"
#include "core/solid.hpp"
#include "core/triangulation.hpp"
#include "host/input.hpp"
#include "host/output.hpp"

// The formats behind files.hpp, which says what each reads and writes.

namespace boxunion::csv {

BoxSet read_boxes(InputFile& file);
void write_box_header(OutputFile& file);
template <class T>
void write_box_rows(OutputFile& file, std::span<const BoxOf<T>> boxes);
void write_vertices(OutputFile& file, const Solid& solid);
void write_extreme_vertices(OutputFile& file, const Evm& evm);
void write_labelled_boxes(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels);
void write_components(OutputFile& file, std::span<const Component> components);

}  // namespace boxunion::csv

namespace boxunion::npy {

BoxSet read_boxes(const InputFile& file);
template <class T>
void write_box_header(OutputFile& file, std::uint64_t count);
template <class T>
void write_box_rows(OutputFile& file, std::span<const BoxOf<T>> boxes);
void write_vertices(OutputFile& file, const Solid& solid);
void write_extreme_vertices(OutputFile& file, const Evm& evm);
void write_labelled_boxes(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels);
void write_components(OutputFile& file, std::span<const Component> components);

}  // namespace boxunion::npy

namespace boxunion::obj {

void write(OutputFile& file, const Brep& brep, const Triangulation& triangulation, bool triangles_only);

}  // namespace boxunion::obj

namespace boxunion::ply {

void write(OutputFile& file, std::span<const Point> points, std::span<const Triangle> triangles);

}  // namespace boxunion::ply

namespace boxunion::off {

void write(OutputFile& file, std::span<const Point> points, std::span<const Triangle> triangles);

}  // namespace boxunion::off

namespace boxunion::stl {

/// Returns false if a coordinate was rounded.
bool write(OutputFile& file, const Brep& brep, const Triangulation& triangulation);

}  // namespace boxunion::stl

namespace boxunion::threemf {

/// Returns false if a coordinate was rounded.
bool write(OutputFile& file, std::span<const Point> points, std::span<const Triangle> triangles);

}  // namespace boxunion::threemf

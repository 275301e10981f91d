#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/box.hpp"
#include "core/solid.hpp"
#include "host/input.hpp"
#include "host/output.hpp"

// The formats behind files.hpp, which says what each reads and writes.

namespace boxunion::csv {

BoxSet read_boxes(InputFile& file);
void write_box_header(OutputFile& file);
template <class T>
void write_box_rows(OutputFile& file, std::span<const BoxOf<T>> boxes);
void write_vertices(OutputFile& file, const Solid& solid);

}  // namespace boxunion::csv

namespace boxunion::npy {

BoxSet read_boxes(const InputFile& file);
template <class T>
void write_box_header(OutputFile& file, std::uint64_t count);
template <class T>
void write_box_rows(OutputFile& file, std::span<const BoxOf<T>> boxes);
void write_vertices(OutputFile& file, const Solid& solid);

}  // namespace boxunion::npy

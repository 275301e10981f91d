#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "host/files/box_file.hpp"
#include "host/files/formats.hpp"
#include "host/files/npy_header.hpp"
#include "host/files/voxel_data.hpp"

namespace boxunion::npy {
namespace {

constexpr std::size_t kRowsAtOnce = 1 << 15;

template <class T>
T byte_swapped(T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// True if a double equals this integer.
bool is_double(std::int64_t value) {
  const std::uint64_t magnitude = value < 0 ? 0 - std::uint64_t(value) : std::uint64_t(value);
  return value == 0 || magnitude >> std::countr_zero(magnitude) < std::uint64_t{1} << 53;
}

/// The place of the array in the file.
struct Layout {
  std::uint64_t offset;
  std::uint64_t rows;
  bool fortran_order, swapped;
};

/// The first number that no double equals, and its row, counted from 0.
struct Inexact {
  std::size_t row;
  std::int64_t value;
};

/// An array of numbers of type Stored, read as boxes of type T.
template <class Stored, class T>
class BoxArray final : public BoxFile {
 public:
  BoxArray(std::shared_ptr<const InputFile> file, const Layout& layout)
      : file_(std::move(file)), layout_(layout) {
    const std::uint64_t bytes = *file_->size() - layout.offset;
    if (bytes / (6 * sizeof(Stored)) < layout.rows)
      reject(*file_, fmt::format("the file is cut off: the header says {} rows, found the bytes of {}",
                                 layout.rows, bytes / (6 * sizeof(Stored))));
    if (bytes != layout.rows * 6 * sizeof(Stored))
      reject(*file_, fmt::format("found {} bytes after the {} rows of the header, expected none",
                                 bytes - layout.rows * 6 * sizeof(Stored), layout.rows));
  }

  std::uint64_t size() const override { return layout_.rows; }
  std::string name_of(std::uint64_t row) const override {
    return fmt::format("{}: row {}", file_->name(), row + 1);
  }
  BoxSet read(std::uint64_t begin, std::uint64_t end) const override {
    std::vector<BoxOf<T>> boxes(end - begin);
    std::vector<Stored> raw;
    check(read_rows(begin, boxes, raw));
    return boxes;
  }
  /// All boxes, read in parallel.
  BoxSet read_all() const {
    std::vector<BoxOf<T>> boxes = with_memory(file_->name(), layout_.rows * sizeof(BoxOf<T>),
                                              [&] { return std::vector<BoxOf<T>>(layout_.rows); });
    const auto earlier = [](const Inexact& a, const Inexact& b) { return b.row < a.row ? b : a; };
    check(parallel_reduce(
        0, boxes.size(), kRowsAtOnce, Inexact{layout_.rows, 0},
        [&](std::size_t begin, std::size_t end, Inexact first) {
          std::vector<Stored> raw;
          for (std::size_t row = begin; row < end && row < first.row; row += kRowsAtOnce)
            first = earlier(
                first, read_rows(row, std::span(boxes).subspan(row, std::min(kRowsAtOnce, end - row)), raw));
          return first;
        },
        earlier));
    return boxes;
  }

 private:
  void read_stored(std::uint64_t index, std::span<Stored> values) const {
    file_->read_at(layout_.offset + index * sizeof(Stored),
                   {reinterpret_cast<char*>(values.data()), values.size_bytes()});
  }
  /// Reads rows from `begin` on until all are read or a number is no double.
  Inexact read_rows(std::uint64_t begin, std::span<BoxOf<T>> boxes, std::vector<Stored>& raw) const {
    const std::size_t rows = boxes.size();
    if (rows == 0) return {layout_.rows, 0};
    if constexpr (std::is_same_v<Stored, T>)
      if (!layout_.fortran_order && !layout_.swapped) {
        read_stored(6 * begin, {boxes[0].data(), 6 * rows});
        return {layout_.rows, 0};
      }
    raw.resize(6 * rows);
    if (layout_.fortran_order)
      for (std::size_t c = 0; c < 6; ++c) read_stored(c * layout_.rows + begin, {&raw[c * rows], rows});
    else
      read_stored(6 * begin, raw);
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t c = 0; c < 6; ++c) {
        Stored value = raw[layout_.fortran_order ? c * rows + r : 6 * r + c];
        if (layout_.swapped) value = byte_swapped(value);
        if constexpr (std::is_same_v<Stored, std::int64_t>)
          if (!is_double(value)) return {begin + r, value};
        boxes[r][c] = T(value);
      }
    return {layout_.rows, 0};
  }
  void check(const Inexact& inexact) const {
    if (inexact.row < layout_.rows)
      reject(*file_, fmt::format("row {}: no double equals {}, expected at most 53 significant bits",
                                 inexact.row + 1, inexact.value));
  }

  std::shared_ptr<const InputFile> file_;
  Layout layout_;
};

/// Calls f(array) with the array of boxes that a header describes.
template <class F>
auto with_array(const std::shared_ptr<const InputFile>& file, const Header& header, F&& f) {
  const char order = header.descr.front();
  const std::string type = header.descr.substr(1);
  const bool known_order = order == '<' || order == '>' || order == '=';
  const bool known_type = type == "f8" || type == "f4" || type == "i4" || type == "i8";
  if (!known_order || !known_type)
    reject(*file, fmt::format("found numbers of type {}, expected float64 (f8), float32 (f4), int32 (i4) or "
                              "int64 (i8)",
                              shortened(header.descr)));
  const auto extents = header.extents();
  if (!extents || extents->size() != 2 || extents->back() != 6)
    reject(*file, fmt::format("found an array of shape {}, expected (n, 6), or (z, y, x) for voxels",
                              shortened(header.shape)));
  const Layout layout{header.data_offset, extents->front(), header.is_fortran(), order == '>'};
  if (type == "f8") return f(BoxArray<double, double>(file, layout));
  if (type == "f4") return f(BoxArray<float, double>(file, layout));
  if (type == "i4") return f(BoxArray<std::int32_t, std::int32_t>(file, layout));
  return f(BoxArray<std::int64_t, double>(file, layout));
}

/// An array of shape (n, 6), or of three extents: z, y and x.
class Input final : public InputBoxes {
 public:
  Input(std::shared_ptr<const InputFile> file, const VolumeOptions& options)
      : file_(std::move(file)), header_(read_header(*file_)), options_(options) {}

  bool is_volume() const override {
    const auto extents = header_.extents();
    return extents && extents->size() == 3;
  }
  BoxSet read() override {
    if (is_volume()) return volume()->read();
    BoxSet boxes = with_array(file_, header_, [](const auto& array) { return array.read_all(); });
    const std::size_t invalid = find_invalid(boxes);
    if (invalid < boxes.size())
      validate(boxes[invalid], fmt::format("{}: row {}", file_->name(), invalid + 1));
    return boxes;
  }
  std::unique_ptr<BoxFile> open(const Budget& budget) override {
    if (is_volume()) return volume()->open(budget);
    return with_array(file_, header_, []<class A>(A&& array) -> std::unique_ptr<BoxFile> {
      return std::make_unique<A>(std::forward<A>(array));
    });
  }
  Volume read_volume() override {
    if (!is_volume()) reject(*file_, "found an array of boxes, expected one of voxels, of shape (z, y, x)");
    Volume volume = this->volume()->read_volume();
    return header_.is_fortran() ? transposed(volume) : volume;
  }

 private:
  std::unique_ptr<InputBoxes> volume() const {
    return volume_input(file_, open_volume(file_, header_, options_));
  }

  std::shared_ptr<const InputFile> file_;
  Header header_;
  VolumeOptions options_;
};

static_assert(std::endian::native == std::endian::little, "the writers below copy numbers as they are");

template <class T>
void begin_boxes(OutputFile& file, std::uint64_t count) {
  write_header(file, std::is_same_v<T, double> ? "'<f8'" : "'<i4'", fmt::format("({}, 6)", count));
}

template <class T>
void write_boxes(OutputFile& file, std::span<const BoxOf<T>> boxes) {
  constexpr std::size_t kRows = 1 << 17;  // small, so that an interrupt is noticed soon
  for (; !boxes.empty(); boxes = boxes.subspan(std::min(kRows, boxes.size())))
    file.write_array(boxes.first(std::min(kRows, boxes.size())));
}

void begin_vertices(OutputFile& file, std::uint64_t count) {
  write_header(file, "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('mask', '|u1'), ('degrees', '|u1', (6,))]",
               fmt::format("({},)", count));
}

void write_vertices(OutputFile& file, std::span<const PlacedVertex> vertices) {
  for (const PlacedVertex& v : vertices) {
    std::array<char, 31> record;
    std::memcpy(record.data(), v.point.data(), 24);
    record[24] = char(v.mask);
    std::memcpy(record.data() + 25, kOctants[v.mask].degrees.data(), 6);
    file.write({record.data(), record.size()});
  }
}

void begin_points(OutputFile& file, std::uint64_t count) {
  write_header(file, "'<f8'", fmt::format("({}, 3)", count));
}

void write_points(OutputFile& file, std::span<const Point> points) {
  file.write_array(points);
}

void write_labelled_boxes(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels) {
  boxes.visit([&]<class T>(const std::vector<BoxOf<T>>& all) {
    write_header(
        file,
        fmt::format("[('box', '{}', (6,)), ('label', '<u4')]", std::is_same_v<T, double> ? "<f8" : "<i4"),
        fmt::format("({},)", all.size()));
    for (std::size_t i = 0; i < all.size(); ++i) {
      file.write_array(std::span<const T>(all[i]));
      file.write_array(labels.subspan(i, 1));
    }
  });
}

void write_components(OutputFile& file, std::span<const Component> components) {
  write_header(file, "[('label', '<u8'), ('boxes', '<u8'), ('volume', '<f8'), ('bounds', '<f8', (6,))]",
               fmt::format("({},)", components.size()));
  for (std::size_t i = 0; i < components.size(); ++i) {
    const Component& c = components[i];
    file.write_array(std::span<const std::uint64_t>(std::array<std::uint64_t, 2>{i + 1, c.boxes}));
    file.write_array(std::span(&c.volume, 1));
    for (const auto& corner : c.bounds) file.write_array(std::span<const double>(corner));
  }
}

}  // namespace

std::unique_ptr<InputBoxes> read(std::shared_ptr<InputFile> file, const VolumeOptions& options) {
  return std::make_unique<Input>(std::move(file), options);
}

extern const RowFormat rows;
const RowFormat rows = {.begin_boxes = begin_boxes<double>,
                        .begin_integer_boxes = begin_boxes<std::int32_t>,
                        .boxes = write_boxes<double>,
                        .integer_boxes = write_boxes<std::int32_t>,
                        .begin_vertices = begin_vertices,
                        .vertices = write_vertices,
                        .begin_points = begin_points,
                        .points = write_points,
                        .labelled_boxes = write_labelled_boxes,
                        .components = write_components};

}  // namespace boxunion::npy

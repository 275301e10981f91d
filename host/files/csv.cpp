#include <fast_float/fast_float.h>
#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/parallel.hpp"
#include "host/files/formats.hpp"
#include "host/files/spooled_boxes.hpp"
#include "host/files/text_rows.hpp"
#include "host/files/voxel_data.hpp"

namespace boxunion::csv {
namespace {

constexpr std::size_t kFirstBlockBytes = 1 << 20;  ///< first block of a file in memory; most files are small
constexpr std::size_t kBlockBytes = 8 << 20;  ///< maximum block of a file in memory; no line may be longer
constexpr std::size_t kChunkBytes = 1 << 17;  ///< parsed by one thread at a time
constexpr std::size_t kPiecesAtOnce = 32;     ///< maximum number of chunks whose boxes are in memory at once
constexpr std::string_view kHeader = "xmin,ymin,zmin,xmax,ymax,zmax";

/// Receives boxes in the order of the file.
using BoxSink = std::function<void(std::span<const Box>)>;

bool is_space(char c) {
  return c == ' ' || c == '\t';
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// Removes the first line from `text` and returns it without its line end.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return trim(line);
}

bool is_blank(std::string_view line) {
  return line.empty() || line.front() == '#';
}

bool is_header(std::string_view line) {
  std::string plain;
  for (const char c : line)
    if (!is_space(c)) plain += 'A' <= c && c <= 'Z' ? char(c + 'a' - 'A') : c;
  return plain == kHeader;
}

/// Reads one number at the start of [p, end). Returns the position behind it, or null if there is no number.
/// A number beyond the range of double becomes infinite.
const char* parse_number(const char* p, const char* end, double& value) {
  if (p != end && *p == '+' && p + 1 != end && p[1] != '-') ++p;
  const auto [rest, error] = fast_float::from_chars(p, end, value);
  return error == std::errc::invalid_argument ? nullptr : rest;
}

/// Reads a line of six numbers. Returns false for anything else.
bool parse_row(std::string_view line, Box& box) {
  const char* p = line.data();
  const char* const end = p + line.size();
  for (std::size_t c = 0; c < 6; ++c) {
    while (p != end && is_space(*p)) ++p;
    p = parse_number(p, end, box[c]);
    if (!p) return false;
    while (p != end && is_space(*p)) ++p;
    if (c < 5 && (p == end || *p++ != ',')) return false;
  }
  return p == end;
}

/// The first 40 characters of a field, safe to print on one line.
std::string quoted(std::string_view field) {
  std::string text;
  for (const char c : field.substr(0, 40)) text += c >= 0 && c < ' ' ? '?' : c;
  return fmt::format("\"{}{}\"", text, field.size() > 40 ? "..." : "");
}

/// Throws an error that says why parse_row or the check of its box rejected a line.
[[noreturn]] void reject_row(const std::string& where, std::string_view line) {
  const auto columns = std::ranges::count(line, ',') + 1;
  if (columns != 6)
    throw Error(ErrorKind::input, fmt::format("{}: found {} column{}, expected 6: {}", where, columns,
                                              columns == 1 ? "" : "s", kHeader));
  Box box;
  for (std::size_t c = 0; c < 6; ++c) {
    const std::size_t comma = std::min(line.find(','), line.size());
    const std::string_view field = trim(line.substr(0, comma));
    line.remove_prefix(std::min(comma + 1, line.size()));
    const char* const end = field.data() + field.size();
    const std::string_view column = kHeader.substr(5 * c, 4);
    if (parse_number(field.data(), end, box[c]) != end)
      throw Error(ErrorKind::input,
                  fmt::format("{}: {} is {}, expected a number", where, column, quoted(field)));
    if (std::isinf(box[c]) && field.find_first_of("0123456789") != field.npos)
      throw Error(ErrorKind::input,
                  fmt::format("{}: {} is {}, beyond the range of double", where, column, quoted(field)));
  }
  validate(box, where);
  throw std::logic_error("a valid row was rejected");
}

/// The result of one thread for a piece of the file.
struct Chunk {
  std::vector<Box> boxes;
  std::size_t lines = 0;                     ///< lines read, up to the bad one if there is one
  std::optional<std::string_view> bad_line;  ///< the first line that is not a valid box
};

Chunk parse_chunk(std::string_view text) {
  Chunk chunk;
  Box box;
  while (!text.empty()) {
    const std::string_view line = take_line(text);
    if (!is_blank(line)) {
      if (!parse_row(line, box) || !is_valid(box)) {
        chunk.bad_line = line;
        return chunk;
      }
      chunk.boxes.push_back(box);
    }
    ++chunk.lines;
  }
  return chunk;
}

/// Cuts text into pieces of whole lines.
std::vector<std::string_view> cut(std::string_view text) {
  std::vector<std::string_view> pieces;
  while (!text.empty()) {
    const std::size_t end = text.find('\n', std::min(kChunkBytes, text.size()));
    pieces.push_back(text.substr(0, end == text.npos ? end : end + 1));
    text.remove_prefix(pieces.back().size());
  }
  return pieces;
}

/// Passes the boxes of a file to a sink. The file is fed to it in blocks of whole lines.
class Reader {
 public:
  Reader(const std::string& name, const BoxSink& sink) : name_(name), sink_(sink) {}

  void add(std::string_view text) {
    if (!started_) skip_header(text);
    const std::vector<std::string_view> pieces = cut(text);
    for (std::size_t first = 0; first < pieces.size(); first += kPiecesAtOnce) {
      std::vector<Chunk> chunks(std::min(kPiecesAtOnce, pieces.size() - first));
      parallel_for_each(0, chunks.size(), 1,
                        [&](std::size_t i) { chunks[i] = parse_chunk(pieces[first + i]); });
      for (const Chunk& chunk : chunks) {
        lines_ += chunk.lines;
        if (chunk.bad_line) reject_row(fmt::format("{}:{}", name_, lines_ + 1), *chunk.bad_line);
        sink_(chunk.boxes);
      }
    }
  }

  std::size_t lines() const { return lines_; }
  /// True after the first header or box.
  bool started() const { return started_; }

 private:
  /// Removes what comes before the first box from `text`.
  void skip_header(std::string_view& text) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (lines_ == 0 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    while (!text.empty() && !started_) {
      std::string_view rest = text;
      const std::string_view line = take_line(rest);
      started_ = !is_blank(line);
      if (started_ && !is_header(line)) return;
      text = rest;
      ++lines_;
    }
  }

  std::string name_;
  const BoxSink& sink_;
  std::size_t lines_ = 0;
  bool started_ = false;
};

/// Passes all boxes to `sink`, block by block. Calls expect(t) now and then: the file is about t times as
/// long as the part read so far.
void stream_boxes(InputFile& file, const BoxSink& sink, const std::function<void(double)>& expect = {}) {
  Reader reader(file.name(), sink);
  std::string block;
  std::size_t kept = 0;  // bytes of an unfinished line at the start of the block
  std::uint64_t done = 0;
  for (bool more = true; more;) {
    block.resize(std::clamp(2 * block.size(), kFirstBlockBytes, kBlockBytes));
    const std::size_t size = kept + file.read(std::span(block).subspan(kept));
    more = size == block.size();
    const std::size_t whole = more ? std::string_view(block).rfind('\n') + 1 : size;
    if (more && whole == 0 && size == kBlockBytes)
      throw Error(ErrorKind::input,
                  fmt::format("{}:{}: the line is longer than {} bytes, expected six numbers", file.name(),
                              reader.lines() + 1, kBlockBytes));
    reader.add({block.data(), whole});
    done += whole;
    if (expect && done > 0 && more && file.size()) expect(double(*file.size()) / double(done));
    kept = size - whole;
    std::memmove(block.data(), block.data() + whole, kept);
  }
  if (!reader.started())
    throw Error(
        ErrorKind::input,
        fmt::format("{}: no boxes: {}; expected the header {} or lines of six numbers", file.name(),
                    done == 0 ? "the file is empty" : "the file has only blank lines and comments", kHeader));
}

class Input final : public InputBoxes {
 public:
  explicit Input(std::shared_ptr<InputFile> file) : file_(std::move(file)) {}
  bool is_volume() const override { return false; }

  BoxSet read() override {
    std::vector<Box> boxes;
    stream_boxes(
        *file_, [&](std::span<const Box> block) { boxes.insert(boxes.end(), block.begin(), block.end()); },
        [&](double times) {  // reserves room for all boxes, once
          if (boxes.capacity() < std::size_t(double(boxes.size()) * times))
            boxes.reserve(std::size_t(double(boxes.size()) * times * 1.05));
        });
    return boxes;
  }
  std::unique_ptr<BoxFile> open(const Budget& budget) override {
    auto boxes = std::make_unique<SpooledBoxes>(*file_, budget);
    stream_boxes(*file_, [&](std::span<const Box> block) { boxes->append(block); });
    return boxes;
  }
  Volume read_volume() override { reject(*file_, "found boxes, expected voxels"); }

 private:
  std::shared_ptr<InputFile> file_;
};

void begin_boxes(OutputFile& file, std::uint64_t) {
  file.write(kHeader);
  file.write("\n");
}

template <class T>
void write_boxes(OutputFile& file, std::span<const BoxOf<T>> boxes) {
  write_rows(file, boxes.size(), [&](std::size_t row, fmt::memory_buffer& text) {
    const BoxOf<T>& b = boxes[row];
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},{},{},{},{},{}\n"), b[0], b[1], b[2], b[3], b[4],
                   b[5]);
  });
}

void begin_vertices(OutputFile& file, std::uint64_t) {
  file.write("x,y,z,mask,degree_px,degree_nx,degree_py,degree_ny,degree_pz,degree_nz\n");
}

void write_vertices(OutputFile& file, std::span<const PlacedVertex> vertices) {
  write_rows(file, vertices.size(), [&](std::size_t row, fmt::memory_buffer& text) {
    const PlacedVertex& v = vertices[row];
    const auto& d = kOctants[v.mask].degrees;
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},{},{},{},{},{},{},{},{},{}\n"), v.point[0],
                   v.point[1], v.point[2], v.mask, d[0], d[1], d[2], d[3], d[4], d[5]);
  });
}

void begin_points(OutputFile& file, std::uint64_t) {
  file.write("x,y,z\n");
}

void write_points(OutputFile& file, std::span<const Point> points) {
  write_rows(file, points.size(), [&](std::size_t row, fmt::memory_buffer& text) {
    const Point& p = points[row];
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},{},{}\n"), p[0], p[1], p[2]);
  });
}

void write_labelled_boxes(OutputFile& file, const BoxSet& boxes, std::span<const std::uint32_t> labels) {
  file.write(kHeader);
  file.write(",label\n");
  boxes.visit([&](const auto& all) {
    write_rows(file, all.size(), [&](std::size_t row, fmt::memory_buffer& text) {
      for (const auto coordinate : all[row])
        fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},"), coordinate);
      fmt::format_to(std::back_inserter(text), FMT_COMPILE("{}\n"), labels[row]);
    });
  });
}

void write_components(OutputFile& file, std::span<const Component> components) {
  file.write("label,boxes,volume,");
  file.write(kHeader);
  file.write("\n");
  write_rows(file, components.size(), [&](std::size_t row, fmt::memory_buffer& text) {
    const Component& c = components[row];
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},{},{},{},{},{},{},{},{}\n"), row + 1, c.boxes,
                   c.volume, c.bounds[0][0], c.bounds[0][1], c.bounds[0][2], c.bounds[1][0], c.bounds[1][1],
                   c.bounds[1][2]);
  });
}

}  // namespace

std::unique_ptr<InputBoxes> read(std::shared_ptr<InputFile> file, const VolumeOptions&) {
  return std::make_unique<Input>(std::move(file));
}

extern const RowFormat rows;
const RowFormat rows = {.begin_boxes = begin_boxes,
                        .begin_integer_boxes = begin_boxes,
                        .boxes = write_boxes<double>,
                        .integer_boxes = write_boxes<std::int32_t>,
                        .begin_vertices = begin_vertices,
                        .vertices = write_vertices,
                        .begin_points = begin_points,
                        .points = write_points,
                        .labelled_boxes = write_labelled_boxes,
                        .components = write_components};

}  // namespace boxunion::csv

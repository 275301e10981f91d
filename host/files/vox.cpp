#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"
#include "core/voxels/voxel_boxes.hpp"
#include "host/files/formats.hpp"
#include "host/files/spooled_boxes.hpp"
#include "host/files/voxel_data.hpp"

// The format: https://github.com/ephtracy/voxel-model, MagicaVoxel-file-format-vox.txt and -vox-extension.txt

namespace boxunion::vox {
namespace {

/// A file read in blocks.
class Blocks {
 public:
  explicit Blocks(const InputFile& file) : file_(file), size_(regular_size(file)) {}

  const InputFile& file() const { return file_; }
  std::uint64_t size() const { return size_; }
  /// Fills `bytes`, which must be fewer than a block, from an offset on.
  void read(std::uint64_t offset, std::span<char> bytes) {
    if (offset < begin_ || offset + bytes.size() > begin_ + block_.size()) {
      begin_ = offset;
      block_.resize(std::size_t(std::min<std::uint64_t>(kBlockBytes, size_ - offset)));
      file_.read_at(begin_, block_);
    }
    std::copy_n(block_.begin() + std::ptrdiff_t(offset - begin_), bytes.size(), bytes.begin());
  }

 private:
  static constexpr std::uint64_t kBlockBytes = 1 << 16;

  const InputFile& file_;
  std::uint64_t size_, begin_ = 0;
  std::vector<char> block_;
};

/// Takes values from a part of the file, in order.
class Reader {
 public:
  Reader(Blocks& blocks, std::uint64_t begin, std::uint64_t end)
      : blocks_(&blocks), offset_(begin), end_(end) {}

  bool is_empty() const { return offset_ == end_; }
  std::uint64_t offset() const { return offset_; }
  std::uint64_t left() const { return end_ - offset_; }
  [[noreturn]] void fail(const std::string& problem) const {
    reject(blocks_->file(), fmt::format("offset {}: {}", offset_, problem));
  }

  void skip(std::uint64_t count) {
    if (count > left())
      fail(fmt::format("found {} bytes, expected {} more: the file is cut off", left(), count));
    offset_ += count;
  }
  Reader take_part(std::uint64_t count) {
    const std::uint64_t begin = offset_;
    skip(count);
    return {*blocks_, begin, offset_};
  }
  template <class T>
  T take() {
    const std::uint64_t begin = offset_;
    skip(sizeof(T));
    T value;
    blocks_->read(begin, {reinterpret_cast<char*>(&value), sizeof value});
    return value;
  }
  std::uint32_t take_number() { return take<std::uint32_t>(); }
  /// Takes a text. Returns at most its first `most` bytes.
  std::string take_text(std::uint32_t most) {
    const std::uint32_t length = take_number();
    const std::uint64_t begin = offset_;
    skip(length);
    std::string text(std::min(length, most), '\0');
    if (!text.empty()) blocks_->read(begin, text);
    return text;
  }
  void skip_dictionary() {
    for (std::uint32_t left = take_number(); left > 0; --left) {
      skip(take_number());
      skip(take_number());
    }
  }

 private:
  Blocks* blocks_;
  std::uint64_t offset_, end_;
};

/// The kind of a chunk.
using Kind = std::array<char, 4>;
constexpr Kind kind_of(const char (&name)[5]) {
  return {name[0], name[1], name[2], name[3]};
}

/// x, y, z and colour of a voxel.
using Voxel = std::array<std::uint8_t, 4>;

/// A model: its size, the place of its voxels in the file, and the bounds of the voxels inside.
struct Model {
  std::array<std::uint32_t, 3> size{};
  std::uint64_t begin = 0, end = 0;
  std::array<std::uint32_t, 3> lo{256, 256, 256}, hi{};

  bool is_empty() const { return hi[0] == 0; }
  /// The voxels within the bounds.
  VoxelGrid grid() const {
    VoxelGrid grid;
    for (std::size_t a = 0; a < 3; ++a) {
      grid.size[a] = hi[a] - lo[a];
      grid.origin[a] = lo[a];
    }
    return grid;
  }
};

/// A placement of points. Coordinate i becomes sign[i] * point[from[i]] + shift[i].
struct Placement {
  std::array<std::size_t, 3> from{0, 1, 2};
  std::array<std::int64_t, 3> sign{1, 1, 1}, shift{};

  /// This placement applied after `inner`.
  Placement after(const Placement& inner) const {
    Placement both;
    for (std::size_t i = 0; i < 3; ++i) {
      both.from[i] = inner.from[from[i]];
      both.sign[i] = sign[i] * inner.sign[from[i]];
      both.shift[i] = sign[i] * inner.shift[from[i]] + shift[i];
    }
    return both;
  }
};

/// A node of the scene graph. It moves everything below it: nodes or a model.
struct Node {
  Placement placement;
  std::vector<std::uint32_t> children;
  std::optional<std::uint32_t> model;
  bool was_seen = false;
};

struct Scene {
  std::vector<Model> models;
  std::map<std::uint32_t, Node> nodes;
  std::uint64_t links = 0;  ///< number of children of all nodes
};

bool is_inside(const Voxel& voxel, const VolumeOptions& options) {
  return double(voxel[3]) >= options.threshold.value_or(1);  // colour 0 means empty
}

/// Reads the size of a model, and finds the bounds of its voxels.
Model read_model(Reader size, Reader voxels, const VolumeOptions& options) {
  Model model;
  const Reader start = size;
  for (std::uint32_t& extent : model.size) extent = size.take_number();
  for (const std::uint32_t extent : model.size)
    if (extent < 1 || extent > 256)
      start.fail(fmt::format("found a model of {} x {} x {} voxels, expected 1 to 256 along each axis",
                             model.size[0], model.size[1], model.size[2]));
  const std::uint32_t count = voxels.take_number();
  Reader data = voxels.take_part(sizeof(Voxel) * std::uint64_t{count});
  model.begin = data.offset();
  model.end = voxels.offset();
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto voxel = data.take<Voxel>();
    for (std::size_t a = 0; a < 3; ++a) {
      if (voxel[a] >= model.size[a]) voxels.fail(fmt::format("voxel {} lies outside of its model", i + 1));
      if (!is_inside(voxel, options)) continue;
      model.lo[a] = std::min<std::uint32_t>(model.lo[a], voxel[a]);
      model.hi[a] = std::max<std::uint32_t>(model.hi[a], voxel[a] + 1u);
    }
  }
  return model;
}

/// Rotation _r (three signed rows, packed in a byte).
void set_rotation(Placement& placement, const Reader& reader, const std::string& text) {
  unsigned bits = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bits);
  const std::size_t first = bits & 3, second = bits >> 2 & 3;
  if (error != std::errc{} || end != text.data() + text.size() || bits > 127 || first > 2 || second > 2 ||
      first == second)
    reader.fail(fmt::format("_r is \"{}\", expected a rotation", text));
  placement.from = {first, second, 3 - first - second};
  for (std::size_t i = 0; i < 3; ++i) placement.sign[i] = bits >> (4 + i) & 1 ? -1 : 1;
}

/// Translation _t.
void set_translation(Placement& placement, const Reader& reader, const std::string& text) {
  const char *at = text.data(), *const end = at + text.size();
  for (std::int64_t& shift : placement.shift) {
    while (at != end && *at == ' ') ++at;
    std::int32_t value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{}) reader.fail(fmt::format("_t is \"{}\", expected three whole numbers", text));
    at = next;
    shift = value;
  }
}

/// Reads the first frame of a node.
Placement take_placement(Reader& reader) {
  constexpr std::uint32_t kLongestKey = 3, kLongestValue = 64;  // no key or value that we need is longer
  const Reader frame = reader;
  std::optional<std::string> rotation, translation;
  for (std::uint32_t left = reader.take_number(); left > 0; --left) {
    const std::string key = reader.take_text(kLongestKey), value = reader.take_text(kLongestValue);
    if (key == "_r") rotation = value;
    if (key == "_t") translation = value;
  }
  Placement placement;
  if (rotation) set_rotation(placement, frame, *rotation);
  if (translation) set_translation(placement, frame, *translation);
  return placement;
}

/// Reads the content of a node of the scene graph.
void read_node(Reader reader, const Kind& kind, Scene& scene) {
  const std::uint32_t id = reader.take_number();
  if (scene.nodes.contains(id)) reader.fail(fmt::format("node {} occurs twice", id));
  Node& node = scene.nodes[id];
  reader.skip_dictionary();  // name, hidden
  if (kind == kind_of("nTRN")) {
    node.children.push_back(reader.take_number());
    reader.take_number();  // reserved
    reader.take_number();  // layer
    if (reader.take_number() < 1) reader.fail("found no frame, expected at least 1");
    node.placement = take_placement(reader);
    return;
  }
  for (std::uint32_t left = reader.take_number(); left > 0; --left) {
    const std::uint32_t below = reader.take_number();
    if (kind == kind_of("nGRP"))
      node.children.push_back(below);
    else if (!node.model)
      node.model = below;  // later models are later frames of an animation
    if (kind == kind_of("nSHP")) reader.skip_dictionary();
  }
  scene.links += node.children.capacity();
}

Scene read_scene(Blocks& blocks, const VolumeOptions& options) {
  const InputFile& file = blocks.file();
  Reader reader(blocks, 0, blocks.size());
  if (blocks.size() < 4 || reader.take<Kind>() != kind_of("VOX "))
    reject(file, "not a MagicaVoxel file, expected it to start with \"VOX \"");
  if (const std::uint32_t version = reader.take_number(); version != 150 && version != 200)
    reject(file, fmt::format("found version {}, expected 150 or 200", version));
  if (reader.take<Kind>() != kind_of("MAIN")) reader.fail("found no chunk MAIN");
  const std::uint32_t main_bytes = reader.take_number(), children_bytes = reader.take_number();
  reader.skip(main_bytes);

  Scene scene;
  std::optional<Reader> size;
  for (Reader chunks = reader.take_part(children_bytes); !chunks.is_empty();) {
    const auto kind = chunks.take<Kind>();
    const std::uint32_t content_bytes = chunks.take_number(), inner_bytes = chunks.take_number();
    Reader content = chunks.take_part(content_bytes);
    chunks.skip(inner_bytes);
    if (kind == kind_of("SIZE")) {
      if (size) content.fail("found a chunk SIZE, expected XYZI");
      size = content;
    } else if (kind == kind_of("XYZI")) {
      if (!size) content.fail("found a chunk XYZI, expected SIZE before it");
      scene.models.push_back(read_model(*size, content, options));
      size.reset();
    } else if (kind == kind_of("nTRN") || kind == kind_of("nGRP") || kind == kind_of("nSHP")) {
      read_node(content, kind, scene);
    }
  }
  if (size) size->fail("found a chunk SIZE without XYZI");
  if (scene.models.empty()) reject(file, "found no model, expected chunks SIZE and XYZI");
  return scene;
}

/// The placements of each model, found by a walk through the graph from node 0.
std::vector<std::vector<Placement>> place_models(const InputFile& file, Scene& scene) {
  struct Step {
    const Node* node;
    Placement placement;
    std::size_t next = 0;  // index of the next child
  };
  std::vector<std::vector<Placement>> places(scene.models.size());
  std::vector<Step> path;
  const auto enter = [&](std::uint32_t id, const Placement& outer) {
    const auto found = scene.nodes.find(id);
    if (found == scene.nodes.end()) reject(file, fmt::format("the scene graph has no node {}", id));
    Node& node = found->second;
    if (std::exchange(node.was_seen, true))
      reject(file, fmt::format("the scene graph has node {} twice, expected a tree", id));
    path.push_back({&node, outer.after(node.placement)});
    if (!node.model) return;
    if (*node.model >= places.size())
      reject(file,
             fmt::format("node {} has model {}, expected less than {}", id, *node.model, places.size()));
    places[*node.model].push_back(path.back().placement);
  };
  enter(0, {});
  while (!path.empty()) {
    Interruptible::check();
    Step& step = path.back();
    if (step.next == step.node->children.size()) {
      path.pop_back();
    } else {
      const std::uint32_t child = step.node->children[step.next++];
      enter(child, Placement(step.placement));  // a copy: the path moves as it grows
    }
  }
  return places;
}

/// Passes the boxes of a model at its own coordinates to `take`, some at a time. Looks only within the bounds
/// of its voxels, because many models of a few voxels may claim the maximum size.
template <class Take>
void stream_model(Blocks& blocks, const Model& model, const VolumeOptions& options, Take&& take) {
  if (model.is_empty()) return;
  Volume volume(model.grid());
  const auto& size = volume.grid.size;
  for (Reader voxels(blocks, model.begin, model.end); !voxels.is_empty();)
    if (const auto v = voxels.take<Voxel>(); is_inside(v, options))
      volume.inside[((v[2] - model.lo[2]) * size[1] + v[1] - model.lo[1]) * size[0] + v[0] - model.lo[0]] = 1;
  stream_voxel_boxes(stream_of(volume), [&](const BoxSet& boxes) {
    Interruptible::check();
    boxes.visit([&](const auto& all) {
      if constexpr (std::is_same_v<decltype(all), const std::vector<IntegerBox>&>) take(std::span(all));
    });
  });
}

/// The boxes of a model after a placement, which turns about the middle of the model's size, rounded down.
std::vector<IntegerBox> placed_boxes(const InputFile& file, std::span<const IntegerBox> boxes,
                                     const Model& model, const Placement& placement) {
  std::vector<IntegerBox> result(boxes.size());
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const IntegerBox& box = boxes[k];
    IntegerBox& placed = result[k];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t from = placement.from[i];
      const std::int64_t pivot = model.size[from] / 2;
      const std::int64_t a = placement.sign[i] * (box[from] - pivot) + placement.shift[i];
      const std::int64_t b = placement.sign[i] * (box[from + 3] - pivot) + placement.shift[i];
      if (std::max(std::abs(a), std::abs(b)) > std::numeric_limits<std::int32_t>::max())
        reject(file, fmt::format("a voxel lies at {}, expected coordinates of 32 bits", std::max(a, b)));
      placed[i] = std::int32_t(std::min(a, b));
      placed[i + 3] = std::int32_t(std::max(a, b));
    }
  }
  return result;
}

/// About the memory that streaming a scene may take: its graph and its largest model.
std::uint64_t bytes_of(const Scene& scene) {
  std::uint64_t largest = 0;
  for (const Model& model : scene.models)
    if (!model.is_empty())
      largest = std::max(largest, model.grid().voxels() + boxunion::stream_bytes(model.grid()));
  constexpr std::uint64_t kOfNode = 2 * sizeof(Node) + sizeof(Placement), kOfModel = 2 * sizeof(Model);
  return largest + scene.models.size() * kOfModel + scene.nodes.size() * kOfNode +
         scene.links * sizeof(std::uint32_t);
}

using BoxSink = std::function<void(std::span<const IntegerBox>)>;

/// Passes the boxes of a scene to `take`, some at a time: those of each model, as the scene graph places it.
/// First calls expect(bytes), if given, with about the maximum memory that it will take.
void stream_boxes(const InputFile& file, const VolumeOptions& options, const BoxSink& take,
                  const std::function<void(std::uint64_t)>& expect = {}) {
  Blocks blocks(file);
  Scene scene = read_scene(blocks, options);
  if (options.model && (*options.model < 1 || *options.model > scene.models.size()))
    throw Error(ErrorKind::usage, fmt::format("model is {}, expected 1 to {}, the models of {}",
                                              *options.model, scene.models.size(), file.name()));
  if (expect) expect(bytes_of(scene));
  if (options.model) return stream_model(blocks, scene.models[*options.model - 1], options, take);
  if (scene.nodes.empty()) {
    for (const Model& model : scene.models) stream_model(blocks, model, options, take);
    return;
  }
  const std::vector<std::vector<Placement>> places = place_models(file, scene);
  for (std::size_t m = 0; m < places.size(); ++m)
    if (!places[m].empty())
      stream_model(blocks, scene.models[m], options, [&](std::span<const IntegerBox> boxes) {
        for (const Placement& placement : places[m]) {
          Interruptible::check();
          take(placed_boxes(file, boxes, scene.models[m], placement));
        }
      });
}

/// The voxels of a scene, in the bounds of all of them. Reads the scene twice, so that its boxes are never
/// all in memory.
Volume filled(const InputFile& file, const VolumeOptions& options) {
  constexpr std::int32_t kFirst = std::numeric_limits<std::int32_t>::max(), kLast = -kFirst;
  IntegerBox bounds = {kFirst, kFirst, kFirst, kLast, kLast, kLast};
  stream_boxes(file, options, [&](std::span<const IntegerBox> boxes) {
    for (const IntegerBox& box : boxes)
      for (std::size_t a = 0; a < 3; ++a) {
        bounds[a] = std::min(bounds[a], box[a]);
        bounds[a + 3] = std::max(bounds[a + 3], box[a + 3]);
      }
  });
  if (bounds[0] > bounds[3]) reject(file, "found no voxel");
  VoxelGrid grid;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.size[a] = std::size_t(std::int64_t{bounds[a + 3]} - bounds[a]);
    grid.origin[a] = bounds[a];
  }
  check_extents(file, grid.size);
  Volume volume(grid);
  stream_boxes(file, options, [&](std::span<const IntegerBox> boxes) {
    for (const IntegerBox& box : boxes)
      for (std::int64_t z = box[2]; z < box[5]; ++z)
        for (std::int64_t y = box[1]; y < box[4]; ++y) {
          const std::size_t row =
              (std::size_t(z - bounds[2]) * grid.size[1] + std::size_t(y - bounds[1])) * grid.size[0];
          std::fill_n(&volume.inside[row + std::size_t(std::int64_t{box[0]} - bounds[0])], box[3] - box[0],
                      std::uint8_t{1});
        }
  });
  return volume;
}

class Input final : public InputBoxes {
 public:
  Input(std::shared_ptr<const InputFile> file, const VolumeOptions& options)
      : file_(std::move(file)), options_(options) {}

  bool is_volume() const override { return true; }
  BoxSet read() override {
    std::vector<IntegerBox> all;
    stream_boxes(*file_, options_, [&](std::span<const IntegerBox> boxes) {
      all.insert(all.end(), boxes.begin(), boxes.end());
    });
    return all;
  }
  std::unique_ptr<BoxFile> open(const Budget& budget) override {
    auto spooled = std::make_unique<SpooledBoxes>(*file_, budget);
    stream_boxes(
        *file_, options_, [&](std::span<const IntegerBox> boxes) { spooled->append(boxes); },
        [&](std::uint64_t bytes) { require_memory(*file_, "the models of the scene", bytes, budget); });
    return spooled;
  }
  Volume read_volume() override { return filled(*file_, options_); }

 private:
  std::shared_ptr<const InputFile> file_;
  VolumeOptions options_;
};

}  // namespace

std::unique_ptr<InputBoxes> read(std::shared_ptr<InputFile> file, const VolumeOptions& options) {
  return std::make_unique<Input>(std::move(file), options);
}

}  // namespace boxunion::vox

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/voxel_boxes.hpp"
#include "host/formats.hpp"
#include "host/voxel_data.hpp"

// The format: https://github.com/ephtracy/voxel-model, MagicaVoxel-file-format-vox.txt and -vox-extension.txt

namespace boxunion::vox {
namespace {

using Dictionary = std::map<std::string, std::string, std::less<>>;

/// Takes values off a part of the file.
class Reader {
 public:
  Reader(const InputFile& file, std::string_view bytes, std::size_t offset)
      : file_(&file), bytes_(bytes), offset_(offset) {}

  bool is_empty() const { return bytes_.empty(); }
  std::size_t offset() const { return offset_; }
  [[noreturn]] void fail(const std::string& problem) const {
    reject(*file_, fmt::format("offset {}: {}", offset_, problem));
  }

  std::string_view take(std::size_t count) {
    if (count > bytes_.size())
      fail(fmt::format("found {} bytes, expected {} more: the file is cut off", bytes_.size(), count));
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    offset_ += count;
    return taken;
  }
  std::uint32_t take_number() {
    std::uint32_t number;
    std::memcpy(&number, take(4).data(), 4);
    return number;
  }
  Reader take_part(std::size_t count) {
    const std::size_t at = offset_;
    return {*file_, take(count), at};
  }
  Dictionary take_dictionary() {
    Dictionary dictionary;
    for (std::uint32_t left = take_number(); left > 0; --left) {
      std::string key(take(take_number()));
      dictionary[std::move(key)] = take(take_number());
    }
    return dictionary;
  }

 private:
  const InputFile* file_;
  std::string_view bytes_;
  std::size_t offset_;
};

/// A model: its size, and x, y, z and colour of each voxel.
struct Model {
  std::array<std::uint32_t, 3> size{};
  std::string_view voxels;
};

/// Coordinate i of a point that is moved: sign[i] * point[from[i]] + shift[i].
struct Placement {
  std::array<std::size_t, 3> from{0, 1, 2};
  std::array<std::int64_t, 3> sign{1, 1, 1}, shift{};

  /// First `inner`, then this.
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

/// A node of the scene graph: it moves what is below it, nodes or a model.
struct Node {
  Placement placement;
  std::vector<std::uint32_t> children;
  std::optional<std::uint32_t> model;
};

struct Scene {
  std::vector<Model> models;
  std::map<std::uint32_t, Node> nodes;
};

constexpr std::size_t kBytesAVoxel = 4;

Model read_model(Reader& size, Reader& voxels) {
  Model model;
  const Reader start = size;
  for (std::uint32_t& extent : model.size) extent = size.take_number();
  for (const std::uint32_t extent : model.size)
    if (extent < 1 || extent > 256)
      start.fail(fmt::format("found a model of {} x {} x {} voxels, expected 1 to 256 along each axis",
                             model.size[0], model.size[1], model.size[2]));
  const std::uint32_t count = voxels.take_number();
  model.voxels = voxels.take(kBytesAVoxel * std::size_t{count});
  for (std::size_t i = 0; i < model.voxels.size(); i += kBytesAVoxel)
    for (std::size_t a = 0; a < 3; ++a)
      if (std::uint8_t(model.voxels[i + a]) >= model.size[a])
        voxels.fail(fmt::format("voxel {} lies outside of its model", i / kBytesAVoxel + 1));
  return model;
}

/// Rotation _r (three signed rows, packed in a byte) and translation _t of a frame.
Placement read_placement(const Reader& reader, const Dictionary& frame) {
  Placement placement;
  if (const auto r = frame.find("_r"); r != frame.end()) {
    unsigned bits = 0;
    const auto [end, error] = std::from_chars(r->second.data(), r->second.data() + r->second.size(), bits);
    const std::size_t first = bits & 3, second = bits >> 2 & 3;
    if (error != std::errc{} || *end != '\0' || bits > 127 || first > 2 || second > 2 || first == second)
      reader.fail(fmt::format("_r is \"{}\", expected a rotation", r->second));
    placement.from = {first, second, 3 - first - second};
    for (std::size_t i = 0; i < 3; ++i) placement.sign[i] = bits >> (4 + i) & 1 ? -1 : 1;
  }
  if (const auto t = frame.find("_t"); t != frame.end()) {
    const char *at = t->second.data(), *const end = at + t->second.size();
    for (std::int64_t& shift : placement.shift) {
      while (at != end && *at == ' ') ++at;
      std::int32_t value = 0;
      const auto [next, error] = std::from_chars(at, end, value);
      if (error != std::errc{})
        reader.fail(fmt::format("_t is \"{}\", expected three whole numbers", t->second));
      at = next;
      shift = value;
    }
  }
  return placement;
}

/// Reads the content of a node of the scene graph.
void read_node(Reader reader, std::string_view kind, Scene& scene) {
  const std::uint32_t id = reader.take_number();
  if (scene.nodes.contains(id)) reader.fail(fmt::format("node {} is there twice", id));
  Node& node = scene.nodes[id];
  reader.take_dictionary();  // name, hidden
  if (kind == "nTRN") {
    node.children.push_back(reader.take_number());
    reader.take_number();  // reserved
    reader.take_number();  // layer
    if (reader.take_number() < 1) reader.fail("found no frame, expected at least 1");
    const Reader frame = reader;
    node.placement = read_placement(frame, reader.take_dictionary());
    return;
  }
  for (std::uint32_t left = reader.take_number(); left > 0; --left) {
    const std::uint32_t below = reader.take_number();
    if (kind == "nGRP")
      node.children.push_back(below);
    else if (!node.model)
      node.model = below;  // later ones are later frames of an animation
    if (kind == "nSHP") reader.take_dictionary();
  }
}

Scene read_scene(const InputFile& file, std::string_view bytes) {
  Reader reader(file, bytes, 0);
  if (!bytes.starts_with("VOX ")) reject(file, "not a MagicaVoxel file, expected it to start with \"VOX \"");
  reader.take(4);
  if (const std::uint32_t version = reader.take_number(); version != 150 && version != 200)
    reject(file, fmt::format("found version {}, expected 150 or 200", version));
  if (reader.take(4) != "MAIN") reader.fail("found no chunk MAIN");
  const std::uint32_t main_bytes = reader.take_number(), children_bytes = reader.take_number();
  reader.take(main_bytes);

  Scene scene;
  std::optional<Reader> size;
  for (Reader chunks = reader.take_part(children_bytes); !chunks.is_empty();) {
    const std::string_view kind = chunks.take(4);
    const std::uint32_t content_bytes = chunks.take_number(), inner_bytes = chunks.take_number();
    Reader content = chunks.take_part(content_bytes);
    chunks.take(inner_bytes);
    if (kind == "SIZE") {
      if (size) content.fail("found a chunk SIZE, expected XYZI");
      size = content;
    } else if (kind == "XYZI") {
      if (!size) content.fail("found a chunk XYZI, expected SIZE before it");
      scene.models.push_back(read_model(*size, content));
      size.reset();
    } else if (kind == "nTRN" || kind == "nGRP" || kind == "nSHP") {
      read_node(content, kind, scene);
    }
  }
  if (size) size->fail("found a chunk SIZE without XYZI");
  if (scene.models.empty()) reject(file, "found no model, expected chunks SIZE and XYZI");
  return scene;
}

/// The boxes of a model at its own coordinates. Only the bounds of its voxels are looked at: many models of a
/// few voxels may claim the greatest size.
std::vector<IntegerBox> model_boxes(const Model& model, const VolumeOptions& options) {
  const double threshold = options.threshold.value_or(1);  // colour 0 is none
  std::array<std::size_t, 3> lo{256, 256, 256}, hi{};
  const auto for_each_inside = [&](auto&& f) {
    for (std::size_t i = 0; i < model.voxels.size(); i += kBytesAVoxel) {
      const auto byte = [&](std::size_t b) { return std::size_t(std::uint8_t(model.voxels[i + b])); };
      if (double(byte(3)) >= threshold) f(std::array{byte(0), byte(1), byte(2)});
    }
  };
  for_each_inside([&](const std::array<std::size_t, 3>& voxel) {
    for (std::size_t a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], voxel[a]);
      hi[a] = std::max(hi[a], voxel[a] + 1);
    }
  });
  if (hi[0] == 0) return {};

  Volume volume;
  auto& size = volume.grid.size;
  for (std::size_t a = 0; a < 3; ++a) size[a] = hi[a] - lo[a];
  volume.inside.assign(volume.grid.voxels(), 0);
  for_each_inside([&](const std::array<std::size_t, 3>& voxel) {
    volume.inside[((voxel[2] - lo[2]) * size[1] + voxel[1] - lo[1]) * size[0] + voxel[0] - lo[0]] = 1;
  });
  std::vector<IntegerBox> boxes = index_boxes(stream_of(volume));
  for (IntegerBox& box : boxes)
    for (std::size_t c = 0; c < 6; ++c) box[c] += std::int32_t(lo[c % 3]);
  return boxes;
}

/// The boxes of a model, which turns about the middle of its size, rounded down.
std::vector<IntegerBox> placed_boxes(const InputFile& file, const std::vector<IntegerBox>& boxes,
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

}  // namespace

void stream_boxes(const InputFile& file, const VolumeOptions& options,
                  const std::function<void(std::span<const IntegerBox>)>& take) {
  const std::uint64_t bytes = regular_size(file);
  std::string content = with_memory(file.name(), bytes, [&] { return std::string(bytes, '\0'); });
  file.read_at(0, content);
  const Scene scene = read_scene(file, content);
  if (options.model) {
    if (*options.model < 1 || *options.model > scene.models.size())
      throw Error(ErrorKind::usage, fmt::format("model is {}, expected 1 to {}, the models of {}",
                                                *options.model, scene.models.size(), file.name()));
    return take(model_boxes(scene.models[*options.model - 1], options));
  }
  std::vector<std::vector<IntegerBox>> boxes;
  boxes.reserve(scene.models.size());
  for (const Model& model : scene.models) boxes.push_back(model_boxes(model, options));
  if (scene.nodes.empty()) {
    for (const auto& of_model : boxes) take(of_model);
    return;
  }

  std::vector<std::pair<std::uint32_t, Placement>> open = {{0, {}}};
  std::set<std::uint32_t> seen;
  while (!open.empty()) {
    const auto [id, outer] = open.back();
    open.pop_back();
    const auto node = scene.nodes.find(id);
    if (node == scene.nodes.end()) reject(file, fmt::format("the scene graph has no node {}", id));
    if (!seen.insert(id).second)
      reject(file, fmt::format("the scene graph has node {} twice, expected a tree", id));
    const Placement placement = outer.after(node->second.placement);
    for (auto child = node->second.children.rbegin(); child != node->second.children.rend(); ++child)
      open.emplace_back(*child, placement);
    if (const auto model = node->second.model) {
      if (*model >= scene.models.size())
        reject(file,
               fmt::format("node {} has model {}, expected less than {}", id, *model, scene.models.size()));
      take(placed_boxes(file, boxes[*model], scene.models[*model], placement));
    }
  }
}

std::vector<IntegerBox> read_boxes(const InputFile& file, const VolumeOptions& options) {
  std::vector<IntegerBox> all;
  stream_boxes(file, options,
               [&](std::span<const IntegerBox> boxes) { all.insert(all.end(), boxes.begin(), boxes.end()); });
  return all;
}

std::uint64_t stream_bytes(const InputFile& file) {
  const VoxelGrid largest{.size = {256, 256, 256}};
  // a voxel of four bytes may be a box, in its model and once more where that is
  return largest.voxels() + boxunion::stream_bytes(largest) +
         regular_size(file) * (1 + 2 * sizeof(IntegerBox) / kBytesAVoxel);
}

}  // namespace boxunion::vox

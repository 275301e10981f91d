#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/temporary.hpp"

// Parts of MagicaVoxel files.
namespace boxunion::scene {

/// A chunk of a .vox file, without inner chunks.
inline std::string chunk(const std::string& kind, const std::string& content) {
  return kind + bytes<std::uint32_t>({std::uint32_t(content.size()), 0}) + content;
}
inline std::string text(const std::string& value) {
  return bytes<std::uint32_t>({std::uint32_t(value.size())}) + value;
}
inline std::string dictionary(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string all = bytes<std::uint32_t>({std::uint32_t(entries.size())});
  for (const auto& [key, value] : entries) all += text(key) + text(value);
  return all;
}
inline std::string vox_file(const std::string& chunks) {
  return "VOX " + bytes<std::uint32_t>({150}) + "MAIN" +
         bytes<std::uint32_t>({0, std::uint32_t(chunks.size())}) + chunks;
}
inline std::string model(const std::vector<std::uint32_t>& size,
                         const std::vector<std::array<std::uint8_t, 4>>& voxels) {
  std::string data = bytes<std::uint32_t>({std::uint32_t(voxels.size())});
  for (const auto& voxel : voxels) data += bytes<std::uint8_t>({voxel.begin(), voxel.end()});
  return chunk("SIZE", bytes(size)) + chunk("XYZI", data);
}
inline std::string transform(std::uint32_t id, std::uint32_t child,
                             const std::vector<std::pair<std::string, std::string>>& frame) {
  return chunk("nTRN", bytes<std::uint32_t>({id}) + dictionary({{"_hidden", "1"}}) +
                           bytes<std::uint32_t>({child, std::uint32_t(-1), 0, 1}) + dictionary(frame));
}
inline std::string group(std::uint32_t id, const std::vector<std::uint32_t>& children) {
  return chunk("nGRP", bytes<std::uint32_t>({id}) + dictionary({}) +
                           bytes<std::uint32_t>({std::uint32_t(children.size())}) + bytes(children));
}
inline std::string shape(std::uint32_t id, std::uint32_t of_model) {
  return chunk("nSHP", bytes<std::uint32_t>({id}) + dictionary({}) + bytes<std::uint32_t>({1, of_model}) +
                           dictionary({}));
}

}  // namespace boxunion::scene

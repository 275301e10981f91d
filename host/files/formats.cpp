#include "host/files/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "boxunion/error.hpp"

namespace boxunion {

// The readers and writers in the table. Each is in the source of its format.

namespace csv {
std::unique_ptr<InputBoxes> read(std::shared_ptr<InputFile>, const VolumeOptions&);
extern const RowFormat rows;
}  // namespace csv
namespace npy {
std::unique_ptr<InputBoxes> read(std::shared_ptr<InputFile>, const VolumeOptions&);
extern const RowFormat rows;
extern const VoxelFormat voxels;
}  // namespace npy
namespace nrrd {
VoxelStream open_volume(std::shared_ptr<const InputFile>, const VolumeOptions&);
}
namespace metaimage {
VoxelStream open_volume(std::shared_ptr<const InputFile>, const VolumeOptions&);
}
namespace tiff {
VoxelStream open_volume(std::shared_ptr<const InputFile>, const VolumeOptions&);
}
namespace vox {
std::unique_ptr<InputBoxes> read(std::shared_ptr<InputFile>, const VolumeOptions&);
}
namespace obj {
std::unique_ptr<MeshWriter> begin(OutputFile&, const MeshSize&);
}
namespace ply {
std::unique_ptr<MeshWriter> begin(OutputFile&, const MeshSize&);
}
namespace off {
std::unique_ptr<MeshWriter> begin(OutputFile&, const MeshSize&);
}
namespace stl {
std::unique_ptr<MeshWriter> begin(OutputFile&, const MeshSize&);
}
namespace threemf {
std::unique_ptr<MeshWriter> begin(OutputFile&, const MeshSize&);
}

namespace {

// tests/fuzz/CMakeLists.txt fuzzes every entry with a reader. It takes the extension from the line.
constexpr Format kFormats[] = {
    {{".csv"}, boxes_in, csv::read, {.rows = &csv::rows}},
    {{".npy"}, boxes_in | voxels_in, npy::read, {.rows = &npy::rows, .voxels = &npy::voxels}},
    {{".nrrd", ".nhdr"}, voxels_in, read_volumes<nrrd::open_volume>},
    {{".mha", ".mhd"}, voxels_in, read_volumes<metaimage::open_volume>},
#ifdef BOXUNION_HAVE_TIFF
    {{".tif", ".tiff"}, voxels_in, read_volumes<tiff::open_volume>},
#else
    {.extensions = {".tif", ".tiff"}, .roles = voxels_in, .missing = "libtiff"},
#endif
    {{".vox"}, voxels_in | models_in, vox::read},
    {{".obj"}, 0, nullptr, {.mesh = obj::begin}},
    {{".ply"}, 0, nullptr, {.mesh = ply::begin}},
    {{".off"}, 0, nullptr, {.mesh = off::begin}},
    {{".stl"}, manifold, nullptr, {.mesh = stl::begin}},
    {{".3mf"}, manifold, nullptr, {.mesh = threemf::begin}},
};

}  // namespace

std::span<const Format> formats() {
  return kFormats;
}

bool Format::serves(FileUse use) const {
  switch (use) {
    case FileUse::input:
      return (roles & (boxes_in | voxels_in)) != 0;
    case FileUse::volume:
      return (roles & voxels_in) != 0;
    case FileUse::scene:
      return (roles & models_in) != 0;
    case FileUse::boxes:
      return writer.rows != nullptr;
    case FileUse::voxels:
      return writer.voxels != nullptr;
    case FileUse::boundary:
      return writer.rows != nullptr || writer.mesh != nullptr;
    case FileUse::mesh:
      return writer.mesh != nullptr;
    case FileUse::manifold:
      return (roles & manifold) != 0;
  }
  return false;
}

std::string extensions(FileUse use, std::string_view last) {
  std::vector<std::string_view> all;
  for (const Format& format : kFormats)
    if (format.serves(use))
      for (const std::string_view extension : format.extensions)
        if (!extension.empty()) all.push_back(extension);
  std::string list;
  for (std::size_t i = 0; i < all.size(); ++i)
    list += fmt::format("{}{}", i == 0 ? "" : i + 1 == all.size() ? last : ", ", all[i]);
  return list;
}

const Format& format_of(const std::string& path, FileUse use) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return 'A' <= c && c <= 'Z' ? char(c + 'a' - 'A') : c; });
  for (const Format& format : kFormats)
    if (!extension.empty() && format.serves(use) && std::ranges::count(format.extensions, extension) > 0) {
      if (!format.missing.empty())
        throw Error(ErrorKind::usage,
                    fmt::format("{}: this boxunion was built without {}", path, format.missing));
      return format;
    }
  throw Error(ErrorKind::input,
              fmt::format("{}: {}, expected {}", path,
                          extension.empty() ? "no file extension" : "unknown extension " + extension,
                          extensions(use)));
}

bool is_mesh(const std::string& path) {
  return format_of(path, FileUse::boundary).serves(FileUse::mesh);
}

NonManifold default_contacts(const std::string& path) {
  return format_of(path, FileUse::boundary).serves(FileUse::manifold) ? NonManifold::split
                                                                      : NonManifold::keep;
}

std::unique_ptr<InputBoxes> open_input(const std::string& path, FileUse use, const VolumeOptions& options) {
  const Format& format = path == "-" && use == FileUse::input ? kFormats[0] : format_of(path, use);
  const auto file = std::make_shared<InputFile>(path);
  if (options.model && !format.serves(FileUse::scene))
    throw Error(ErrorKind::usage, fmt::format("{}: only {} files have models to choose", file->name(),
                                              extensions(FileUse::scene)));
  std::unique_ptr<InputBoxes> input = format.reader(file, options);
  if (use == FileUse::input && options.threshold && !input->is_volume())
    throw Error(ErrorKind::usage,
                fmt::format("{}: found boxes, but a threshold is for voxels", file->name()));
  return input;
}

}  // namespace boxunion

// 3MF and its archive, read back by a reader of our own and by lib3mf.

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <sstream>

#ifdef BOXUNION_HAVE_LIB3MF
#include <Model/COM/NMR_DLLInterfaces.h>
#endif

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "host/engine/threads.hpp"
#include "host/files/files.hpp"
#include "host/files/zip.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

template <class T>
T number_at(const std::string& bytes, std::size_t offset) {
  T number;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

/// The entries of an archive without ZIP64, checked against its directory.
std::map<std::string, std::string> unzip(const std::string& archive) {
  std::map<std::string, std::string> entries;
  const std::size_t end = archive.size() - 22;
  EXPECT_EQ(archive.substr(end, 4), "PK\5\6");
  const auto count = number_at<std::uint16_t>(archive, end + 10);
  std::size_t at = number_at<std::uint32_t>(archive, end + 16);
  for (int i = 0; i < count; ++i) {
    EXPECT_EQ(archive.substr(at, 4), "PK\1\2");
    const auto crc = number_at<std::uint32_t>(archive, at + 16);
    const auto compressed = number_at<std::uint32_t>(archive, at + 20);
    const auto size = number_at<std::uint32_t>(archive, at + 24);
    const std::string name = archive.substr(at + 46, number_at<std::uint16_t>(archive, at + 28));
    const auto local = number_at<std::uint32_t>(archive, at + 42);
    EXPECT_EQ(archive.substr(local, 4), "PK\3\4");
    EXPECT_EQ(archive.substr(local + 14, 12), archive.substr(at + 16, 12));
    EXPECT_EQ(archive.substr(local + 30, name.size()), name);
    const std::size_t data = local + 30 + name.size() + number_at<std::uint16_t>(archive, local + 28);

    std::string text(size, '\0');
    z_stream stream{};
    EXPECT_EQ(inflateInit2(&stream, -MAX_WBITS), Z_OK);
    std::string deflated = archive.substr(data, compressed);
    stream.next_in = reinterpret_cast<Bytef*>(deflated.data());
    stream.avail_in = uInt(deflated.size());
    stream.next_out = reinterpret_cast<Bytef*>(text.data());
    stream.avail_out = uInt(text.size());
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END) << name;
    EXPECT_EQ(stream.avail_in, 0u);
    EXPECT_EQ(stream.avail_out, 0u);
    inflateEnd(&stream);
    EXPECT_EQ(crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size()), crc) << name;
    entries[name] = text;
    at += 46 + name.size() + number_at<std::uint16_t>(archive, at + 30);
  }
  EXPECT_EQ(at, end);
  return entries;
}

struct Mesh {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
};

/// The three numbers in a line of attributes.
template <class T>
std::array<T, 3> attributes(const std::string& line) {
  std::array<T, 3> numbers{};
  std::size_t at = 0;
  for (T& number : numbers) {
    at = line.find('"', at) + 1;
    std::istringstream(line.substr(at, line.find('"', at) - at)) >> number;
    at = line.find('"', at) + 1;
  }
  return numbers;
}

Mesh parse(const std::string& model) {
  Mesh mesh;
  std::istringstream lines(model);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("<vertex ")) mesh.points.push_back(attributes<double>(line));
    if (line.starts_with("<triangle ")) mesh.triangles.push_back(attributes<std::uint32_t>(line));
  }
  return mesh;
}

class ThreeMf : public testing::Test {
 protected:
  std::string write(const Boundary& b) {
    const std::string path = folder_.file("a.3mf");
    EXPECT_TRUE(write_mesh(b.brep, b.triangulation, false, open_output(path, FileUse::boundary)));
    return path;
  }
  TemporaryFolder folder_;
};

Boundary boundary(const BoxSet& boxes, NonManifold contacts) {
  return find_boundary(unite(boxes, {.device = "native"}), contacts, {});
}

std::vector<BoxSet> inputs() {
  return {std::vector<Box>{{0, 0, 0, 1 / 3., 1, 1e-30}, {-1e8, .1, 0, .2, .7, 1e9 / 3}, {.2, .7, 0, 1, 1, 1}},
          collect(generate_sponge(2)),
          collect(generate_checkerboard(5)),
          collect(generate_cubes(30'000, 9, 500, 1)),
          {}};
}

TEST_F(ThreeMf, BringsBackEveryPointAndTriangle) {
  for (const BoxSet& boxes : inputs())
    for (const NonManifold contacts : {NonManifold::keep, NonManifold::split}) {
      const Boundary b = boundary(boxes, contacts);
      write(b);
      auto parts = unzip(folder_.read("a.3mf"));
      EXPECT_EQ(parts.size(), 3u);
      EXPECT_TRUE(parts["[Content_Types].xml"].find("Extension=\"model\"") != std::string::npos);
      EXPECT_TRUE(parts["_rels/.rels"].find("Target=\"/3D/3dmodel.model\"") != std::string::npos);
      const Mesh mesh = parse(parts["3D/3dmodel.model"]);
      EXPECT_TRUE(std::ranges::equal(mesh.points, b.brep.points));
      EXPECT_TRUE(std::ranges::equal(mesh.triangles, b.triangulation.triangles));
    }
}

TEST_F(ThreeMf, HoldsFewerThan2To31Points) {
  OutputFile file = open_output(folder_.file("a.3mf"), FileUse::boundary);
  try {
    begin_mesh(file, {.points = std::uint64_t{1} << 31, .triangles = 12});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::resources);
    EXPECT_TRUE(
        std::string(error.what())
            .ends_with("a.3mf: 2147483648 points and 12 triangles, but 3MF holds fewer than 2^31 of each"))
        << error.what();
  }
}

#ifdef BOXUNION_HAVE_LIB3MF

struct Release {
  void operator()(NMR::PLib3MFBase* object) const { NMR::lib3mf_release(object); }
};
template <class T>
using Handle = std::unique_ptr<T, Release>;

template <class T, class Create>
Handle<T> created(Create create) {
  T* object = nullptr;
  EXPECT_EQ(create(&object), 0);
  return Handle<T>(object);
}

/// Reads a file with lib3mf and expects no warning.
Mesh read_with_lib3mf(const std::string& path) {
  const auto model = created<NMR::PLib3MFModel>([](auto** p) { return NMR::lib3mf_createmodel(p); });
  const auto reader = created<NMR::PLib3MFModelReader>(
      [&](auto** p) { return NMR::lib3mf_model_queryreader(model.get(), "3mf", p); });
  EXPECT_EQ(NMR::lib3mf_reader_setstrictmodeactive(reader.get(), true), 0);
  EXPECT_EQ(NMR::lib3mf_reader_readfromfileutf8(reader.get(), path.c_str()), 0) << path;
  DWORD warnings = 1;
  EXPECT_EQ(NMR::lib3mf_reader_getwarningcount(reader.get(), &warnings), 0);
  EXPECT_EQ(warnings, 0u);
  DWORD unit = 0;
  EXPECT_EQ(NMR::lib3mf_model_getunit(model.get(), &unit), 0);
  EXPECT_EQ(unit, DWORD(NMR::MODELUNIT_MILLIMETER));

  Mesh mesh;
  const auto meshes = created<NMR::PLib3MFModelResourceIterator>(
      [&](auto** p) { return NMR::lib3mf_model_getmeshobjects(model.get(), p); });
  const auto items = created<NMR::PLib3MFModelBuildItemIterator>(
      [&](auto** p) { return NMR::lib3mf_model_getbuilditems(model.get(), p); });
  BOOL has_mesh = false, has_item = false;
  EXPECT_EQ(NMR::lib3mf_resourceiterator_movenext(meshes.get(), &has_mesh), 0);
  EXPECT_EQ(NMR::lib3mf_builditemiterator_movenext(items.get(), &has_item), 0);
  EXPECT_EQ(has_mesh, has_item);
  if (!has_mesh) return mesh;
  const auto object = created<NMR::PLib3MFModelResource>(
      [&](auto** p) { return NMR::lib3mf_resourceiterator_getcurrent(meshes.get(), p); });
  DWORD points = 0, triangles = 0;
  EXPECT_EQ(NMR::lib3mf_meshobject_getvertexcount(object.get(), &points), 0);
  EXPECT_EQ(NMR::lib3mf_meshobject_gettrianglecount(object.get(), &triangles), 0);
  for (DWORD i = 0; i < points; ++i) {
    NMR::MODELMESHVERTEX v;
    EXPECT_EQ(NMR::lib3mf_meshobject_getvertex(object.get(), i, &v), 0);
    mesh.points.push_back({v.m_fPosition[0], v.m_fPosition[1], v.m_fPosition[2]});
  }
  for (DWORD i = 0; i < triangles; ++i) {
    NMR::MODELMESHTRIANGLE t;
    EXPECT_EQ(NMR::lib3mf_meshobject_gettriangle(object.get(), i, &t), 0);
    mesh.triangles.push_back({t.m_nIndices[0], t.m_nIndices[1], t.m_nIndices[2]});
  }
  EXPECT_EQ(NMR::lib3mf_resourceiterator_movenext(meshes.get(), &has_mesh), 0);
  EXPECT_FALSE(has_mesh);
  return mesh;
}

TEST_F(ThreeMf, IsReadByLib3mfWithoutAWarning) {
  for (const BoxSet& boxes : inputs()) {
    const Boundary b = boundary(boxes, NonManifold::split);
    const Mesh mesh = read_with_lib3mf(write(b));
    const auto as_floats = [](Point p) {
      for (double& c : p) c = float(c);
      return p;
    };
    EXPECT_TRUE(std::ranges::equal(mesh.points, b.brep.points, {}, {}, as_floats));
    EXPECT_TRUE(std::ranges::equal(mesh.triangles, b.triangulation.triangles));
  }
}

TEST_F(ThreeMf, IsReadByLib3mfAsZip64) {
  const std::string path = write(boundary(collect(generate_sponge(1)), NonManifold::split));
  const Mesh expected = read_with_lib3mf(path);
  EXPECT_EQ(folder_.read("a.3mf").find("PK\6\6"), std::string::npos);
  OutputFile file(folder_.file("large.3mf"));
  ZipWriter archive(file, 0);
  for (const auto& [name, text] : unzip(folder_.read("a.3mf"))) {
    archive.begin(name);
    archive.write(text);
  }
  archive.finish();
  file.commit();
  EXPECT_NE(folder_.read("large.3mf").find("PK\6\6"), std::string::npos);
  const Mesh mesh = read_with_lib3mf(folder_.file("large.3mf"));
  EXPECT_EQ(mesh.points, expected.points);
  EXPECT_EQ(mesh.triangles, expected.triangles);
  EXPECT_FALSE(mesh.triangles.empty());
}

#endif

TEST(Zip, DoesNotDependOnTheSizesOfWrites) {
  const TemporaryFolder folder;
  const std::uint64_t seed = std::random_device{}();
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  constexpr std::size_t kBatch = std::size_t{1} << 22;
  std::string text(3 * kBatch, ' ');
  for (std::size_t i = 0; i < kBatch; ++i) text[i] = char(random());  // random bytes do not deflate
  for (std::size_t i = kBatch; i < text.size(); ++i) text[i] = "0123456789 \n"[random() % 12];
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kBatch, 2 * kBatch + 77, 3 * kBatch}) {
    const std::string content = text.substr(0, size);
    const auto archive = [&](std::size_t most, int threads) {
      with_threads({.threads = threads}, [&] {
        OutputFile file(folder.file("a.zip"));
        ZipWriter writer(file);
        writer.begin("small");
        writer.write("a few bytes");
        writer.begin("text");
        for (std::size_t at = 0; at < size;) {
          const std::size_t some = 1 + random() % most;
          writer.write(std::string_view(content).substr(at, some));
          at += some;
        }
        writer.finish();
        file.commit();
      });
      return folder.read("a.zip");
    };
    const std::string once = archive(10 * kBatch, 1);
    auto entries = unzip(once);
    EXPECT_EQ(entries.size(), 2u);
    EXPECT_EQ(entries["small"], "a few bytes");
    EXPECT_TRUE(entries["text"] == content);
    EXPECT_TRUE(archive(300'000, 3) == once);
  }
}

}  // namespace
}  // namespace boxunion

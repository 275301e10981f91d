#include <Model/COM/NMR_DLLInterfaces.h>
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/memory.hpp"
#include "host/floats.hpp"
#include "host/formats.hpp"

// lib3mf 1: https://github.com/3MFConsortium/lib3mf/tree/release/1.8.1

namespace boxunion::threemf {
namespace {

/// An object of lib3mf, released at the end.
template <class T>
struct Release {
  void operator()(T* object) const { NMR::lib3mf_release(object); }
};
template <class T>
using Handle = std::unique_ptr<T, Release<T>>;

/// Throws Error(resources) with the reason that `object` gives, if a call failed.
void check(LIB3MFRESULT result, NMR::PLib3MFBase* object) {
  if (result == 0) return;
  DWORD code = 0;
  LPCSTR reason = nullptr;
  if (object) NMR::lib3mf_getlasterror(object, &code, &reason);
  throw Error(ErrorKind::resources, fmt::format("lib3mf failed: {}", reason ? reason : "no reason given"));
}

/// What lib3mf creates through an out-parameter: create(&pointer) must succeed, else `parent` says why.
template <class T, class Create>
Handle<T> created(NMR::PLib3MFBase* parent, Create create) {
  T* object = nullptr;
  check(create(&object), parent);
  return Handle<T>(object);
}

/// lib3mf 1 writes floats as whole millionths, which it computes in floats: are these what they should be?
bool is_whole(float millionths, double expected) {
  return double(millionths) == expected && std::trunc(expected) == expected;
}

/// A file in memory, for lib3mf seeks in what it writes.
struct Buffer {
  std::string bytes;
  std::size_t position = 0;

  static std::uint32_t write(BYTE* data, std::uint32_t size, void* user) {
    auto& self = *static_cast<Buffer*>(user);
    try {
      if (self.bytes.size() < self.position + size) self.bytes.resize(self.position + size);
    } catch (const std::bad_alloc&) {
      return 1;
    }
    std::copy(data, data + size, self.bytes.begin() + std::ptrdiff_t(self.position));
    self.position += size;
    return 0;
  }
  static std::uint32_t seek(std::uint64_t position, void* user) {
    static_cast<Buffer*>(user)->position = position;
    return 0;
  }
};

}  // namespace

bool write(OutputFile& file, std::span<const Point> points, std::span<const Triangle> triangles) {
  FloatRounding round(file.path());
  bool exact = true;
  std::vector<NMR::MODELMESHVERTEX> vertices =
      with_memory("the points of the 3MF file", points.size() * sizeof(NMR::MODELMESHVERTEX),
                  [&] { return std::vector<NMR::MODELMESHVERTEX>(points.size()); });
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      const float position = vertices[i].m_fPosition[a] = round(points[i][a]);
      exact &= is_whole(position * 1e6f, double(position) * 1e6);
    }
  std::vector<NMR::MODELMESHTRIANGLE> indices =
      with_memory("the triangles of the 3MF file", triangles.size() * sizeof(NMR::MODELMESHTRIANGLE),
                  [&] { return std::vector<NMR::MODELMESHTRIANGLE>(triangles.size()); });
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t corner = 0; corner < 3; ++corner) indices[i].m_nIndices[corner] = triangles[i][corner];

  const auto model = created<NMR::PLib3MFModel>(nullptr, [](auto** p) { return NMR::lib3mf_createmodel(p); });
  check(NMR::lib3mf_model_setunit(model.get(), NMR::MODELUNIT_MILLIMETER), model.get());
  if (!triangles.empty()) {
    const auto mesh = created<NMR::PLib3MFModelMeshObject>(
        model.get(), [&](auto** p) { return NMR::lib3mf_model_addmeshobject(model.get(), p); });
    check(NMR::lib3mf_meshobject_setgeometry(mesh.get(), vertices.data(), DWORD(vertices.size()),
                                             indices.data(), DWORD(indices.size())),
          mesh.get());
    created<NMR::PLib3MFModelBuildItem>(model.get(), [&](auto** p) {
      return NMR::lib3mf_model_addbuilditem(model.get(), mesh.get(), nullptr, p);
    });
  }
  const auto writer = created<NMR::PLib3MFModelWriter>(
      model.get(), [&](auto** p) { return NMR::lib3mf_model_querywriter(model.get(), "3mf", p); });
  Buffer buffer;
  check(NMR::lib3mf_writer_writetocallback(writer.get(), reinterpret_cast<void*>(&Buffer::write),
                                           reinterpret_cast<void*>(&Buffer::seek), &buffer),
        writer.get());
  file.write(buffer.bytes);
  return exact && round.exact();
}

}  // namespace boxunion::threemf

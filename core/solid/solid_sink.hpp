#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "boxunion/solid.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

/// Vertices as numbers that sort like them, if the ordinals of the axes have few enough bits.
class VertexCode {
 public:
  explicit VertexCode(const Axes& axes);

  /// False if there are no codes. The other functions are only for vertices with ordinals of the axes.
  bool fits() const { return fits_; }
  std::uint64_t encode(const Vertex& v) const {
    return std::uint64_t{v.z} << z_ | std::uint64_t{v.y} << y_ | std::uint64_t{v.x} << kMaskBits | v.mask;
  }
  Vertex decode(std::uint64_t code) const {
    const auto bits = [code](int from, int to) {
      return static_cast<std::uint32_t>(code >> from & ~(~std::uint64_t{0} << (to - from)));
    };
    return {bits(kMaskBits, y_), bits(y_, z_), static_cast<std::uint32_t>(code >> z_), bits(0, kMaskBits)};
  }

 private:
  static constexpr int kMaskBits = 8;
  int y_, z_;  // first bits of the ordinals
  bool fits_;
};

/// Collects the vertices of a union and sorts them.
class SolidSink : public VertexSink {
 public:
  /// The ordinals of the vertices are on `axes`.
  explicit SolidSink(Axes axes) : axes_(std::move(axes)), code_(axes_) {}

  void add(std::span<const Vertex> vertices) override;
  /// The solid of everything added, sorted in parallel. Leaves the sink empty and without axes. Holds 24
  /// bytes a vertex at its peak, including the result, and the allocator may keep 8 more of freed memory.
  /// Without codes it holds 32. Not while another thread adds.
  Solid take();

 private:
  struct Part {  // one of these is empty
    BlockList<std::uint64_t> codes;
    BlockList<Vertex> vertices;
  };

  Axes axes_;
  VertexCode code_;
  PerThread<Part> parts_;
};

}  // namespace boxunion

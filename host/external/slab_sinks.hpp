#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/radix_sort.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/external/external_union.hpp"

// Sinks for the results of the engine in a slab.

namespace boxunion {

/// The difference from ordinals of a slab to those of the whole, modulo 2^32, if both are lattices.
inline std::uint32_t ordinal_shift(const Axis& slab, const Axis& whole) {
  return static_cast<std::uint32_t>(slab.base() - whole.base());
}

/// The mass of a slab. Sums over a part of the vertices depend on the origin of the coordinates. So those on
/// lattices go to `whole`, a sink of all slabs. Integrals over a region do not depend on it.
class SlabMass : public MassSink {
 public:
  SlabMass(const Axes& axes, const Axes& whole_axes, MassSink* whole) : MassSink(axes), whole_(whole) {
    for (unsigned a = 0; a < 3; ++a) shift_[a] = ordinal_shift(axes[a], whole_axes[a]);
  }
  using MassSink::add;
  void add(std::span<const Vertex> vertices) override {
    if (!whole_) return MassSink::add(vertices);
    std::vector<Vertex> shifted(vertices.begin(), vertices.end());
    for (Vertex& v : shifted) v.x += shift_[0], v.y += shift_[1], v.z += shift_[2];
    whole_->add(shifted);
  }

 private:
  MassSink* whole_;
  std::array<std::uint32_t, 3> shift_{};
};

/// Passes on the vertices of a slab in coordinates of the whole.
template <class C>
class SlabVertices : public VertexSink {
 public:
  using Take = std::function<void(std::span<const ExternalVertex<C>>)>;

  SlabVertices(const Axes& axes, const Axes& whole, const Take& take) : axes_(axes), take_(take) {
    for (unsigned a = 0; a < 3; ++a) shift_[a] = ordinal_shift(axes[a], whole[a]);
  }
  void add(std::span<const Vertex> vertices) override {
    std::vector<ExternalVertex<C>> moved;
    moved.reserve(vertices.size());
    for (const Vertex& v : vertices)
      moved.push_back({{coordinate(0, v.x), coordinate(1, v.y), coordinate(2, v.z)}, v.mask});
    take_(moved);
  }

 private:
  C coordinate(unsigned axis, std::uint32_t ordinal) const {
    if constexpr (std::is_same_v<C, std::uint32_t>)
      return ordinal + shift_[axis];
    else
      return ordered_bits(axes_[axis].coordinate(ordinal));
  }

  Axes axes_;
  const Take& take_;
  std::array<std::uint32_t, 3> shift_{};
};

}  // namespace boxunion

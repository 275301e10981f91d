#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "boxunion/axis.hpp"
#include "boxunion/mass.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

/// What a device has summed over one region of the lattice, in integers: lengths in ordinals, coordinates
/// counted from an origin of its choice (see MassSink). The region's own integrals decide, however they were
/// found:
///   volume, and first[a] = 2 * integral of x_a, second = 3 * integrals of (xx, yy, zz) and
///   4 * integrals of (xy, yz, zx), over the part of the union inside the region;
///   area[a] of the faces normal to axis a and length[a] of the edges along axis a, as far as the region owns
///   them (every part of the boundary belongs to one region, by whatever rule).
/// All is modulo 2^64. That is exact in a region of at most kMostEdge steps an axis from the origin: second
/// moments pass 2^63 there, but about its centre they do not.
struct LatticeSums {
  std::uint64_t vertices = 0, extreme = 0;
  std::int64_t volume = 0;
  std::array<std::int64_t, 3> first{};
  std::array<std::int64_t, 6> second{};
  std::array<std::int64_t, 3> area{}, length{};

  static constexpr std::uint32_t kMostEdge = 1u << 13;

  friend bool operator==(const LatticeSums&, const LatticeSums&) = default;
  /// Adds modulo 2^64, so that parts may wrap where the whole fits.
  LatticeSums& operator+=(const LatticeSums& other);
  /// Adds the box [lo, hi], which the region holds and no other box touches; it owns `ends[a]` (0 to 2) of
  /// the box's two faces normal to axis a. With no ends: a part of the inside of the union. All that `times`.
  void add_box(const std::array<std::uint32_t, 3>& lo, const std::array<std::uint32_t, 3>& hi,
               const std::array<std::uint32_t, 3>& ends, std::int64_t times = 1);
};

/// The exact sums of a union, or of the part of it that a region owns: those of disjoint regions add up to
/// the whole. Integrals over regions (LatticeSums) may come on different axes. Sums over a part of the
/// vertices are no integrals yet and depend on where coordinates count from: on lattices those must share one
/// MassSink.
class MassTotals {
 public:
  struct Sums;  // mass_totals.hpp

  /// Of nothing.
  MassTotals();
  explicit MassTotals(std::unique_ptr<Sums> sums);
  MassTotals(MassTotals&&) noexcept;
  MassTotals& operator=(MassTotals&&) noexcept;
  ~MassTotals();
  MassTotals& operator+=(const MassTotals& other);

  MassProperties result() const;

 private:
  friend class MassSink;
  std::unique_ptr<Sums> sums_;
};

/// Turns vertices into mass properties as they come; holds no vertex.
///
/// The sums (Franklin, UNION3, section 4; weights in octants.hpp) are exact: integers on a lattice,
/// on ranks, products of whole significands in a sum for each exponent (exact.hpp).
class MassSink : public VertexSink {
 public:
  /// `axes` are those of the vertices to come; the sink keeps its own copy.
  explicit MassSink(Axes axes);
  ~MassSink() override;
  void add(std::span<const Vertex> vertices) override;

  /// Adds what a device has summed over a region whose coordinates count from the ordinals `origin`. The
  /// regions must not overlap, and all axes must be lattices (else Error(usage)). Thread-safe.
  void add(const LatticeSums& sums, const std::array<std::uint32_t, 3>& origin);
  /// Extends the bounds by ordinals that occur in the union; only needed beside LatticeSums. Thread-safe.
  void extend_bounds(const OrdinalBox& box);

  /// The sums of everything added so far. Not while another thread adds.
  MassTotals totals() const;
  /// The properties of everything added so far. Not while another thread adds.
  MassProperties result() const { return totals().result(); }

 private:
  struct Sums;
  std::unique_ptr<Sums> sums_;
};

// ---- implementation ----

namespace detail {

template <class T>
void add_wrapping(T& to, std::type_identity_t<T> term) {
  to = static_cast<T>(static_cast<std::uint64_t>(to) + static_cast<std::uint64_t>(term));
}

}  // namespace detail

inline LatticeSums& LatticeSums::operator+=(const LatticeSums& other) {
  vertices += other.vertices;
  extreme += other.extreme;
  detail::add_wrapping(volume, other.volume);
  for (unsigned i = 0; i < 6; ++i) detail::add_wrapping(second[i], other.second[i]);
  for (unsigned a = 0; a < 3; ++a) {
    detail::add_wrapping(first[a], other.first[a]);
    detail::add_wrapping(area[a], other.area[a]);
    detail::add_wrapping(length[a], other.length[a]);
  }
  return *this;
}

inline void LatticeSums::add_box(const std::array<std::uint32_t, 3>& lo,
                                 const std::array<std::uint32_t, 3>& hi,
                                 const std::array<std::uint32_t, 3>& ends, std::int64_t times) {
  // modulo 2^64 on the way: only the sum is known to fit
  const auto add = []<class T>(T& to, std::uint64_t term) { detail::add_wrapping(to, static_cast<T>(term)); };
  const auto factor = static_cast<std::uint64_t>(times);
  std::uint64_t edge[3], sum[3], square[3];  // (hi^2 - lo^2) / edge and (hi^3 - lo^3) / edge
  for (unsigned a = 0; a < 3; ++a) {
    const std::uint64_t l = lo[a], h = hi[a];
    edge[a] = h - l;
    sum[a] = h + l;
    square[a] = sum[a] * sum[a] - h * l;
  }
  const std::uint64_t face[3] = {edge[1] * edge[2], edge[2] * edge[0], edge[0] * edge[1]};
  const std::uint64_t box = factor * edge[0] * face[0];
  const std::uint64_t corners = factor * ends[0] * ends[1] * ends[2];
  add(vertices, corners);
  add(extreme, corners);
  add(volume, box);
  for (unsigned a = 0; a < 3; ++a) {
    const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
    add(first[a], box * sum[a]);
    add(second[a], box * square[a]);
    add(second[3 + a], box * sum[a] * sum[b]);
    add(area[a], factor * face[a] * ends[a]);
    add(length[a], factor * edge[a] * ends[b] * ends[c]);
  }
}

}  // namespace boxunion

#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "boxunion/axis.hpp"
#include "boxunion/mass.hpp"
#include "core/solid/vertex_sink.hpp"

namespace boxunion {

/// Sums over a region of a lattice, in integers. Lengths are in ordinals. Coordinates count from an origin
/// that the caller chooses (see MassSink). The sums are integrals over the region, however they were found:
///   volume, and first[a] = 2 * integral of x_a, second = 3 * integrals of (xx, yy, zz) and 4 * integrals of
///   (xy, yz, zx), over the part of the union inside the region;
///   area[a] of the faces normal to axis a and length[a] of the edges along axis a, as far as the region owns
///   them (every part of the boundary belongs to one region, by any rule).
/// All sums are modulo 2^64. This is exact in a region of at most kMostEdge steps from the origin on each
/// axis: second moments exceed 2^63 there, but not about the centre of the region.
struct LatticeSums {
  std::uint64_t vertices = 0, extreme = 0;
  std::int64_t volume = 0;
  std::array<std::int64_t, 3> first{};
  std::array<std::int64_t, 6> second{};
  std::array<std::int64_t, 3> area{}, length{};

  static constexpr std::uint32_t kMostEdge = 1u << 13;

  friend bool operator==(const LatticeSums&, const LatticeSums&) = default;
  /// Adds modulo 2^64, so parts may wrap if the whole fits.
  LatticeSums& operator+=(const LatticeSums& other);
  /// Adds the box [lo, hi], `times` times. It lies in the region and no other box touches it. The region owns
  /// `ends[a]` (0 to 2) of the two faces of the box normal to axis a. If it owns none, the box is a part of
  /// the inside of the union.
  void add_box(const std::array<std::uint32_t, 3>& lo, const std::array<std::uint32_t, 3>& hi,
               const std::array<std::uint32_t, 3>& ends, std::int64_t times = 1);
};

/// The exact sums of a union, or of the part of it that a region owns. The sums of disjoint regions add up to
/// the whole. Integrals over regions (LatticeSums) may be on different axes. Sums over a part of the vertices
/// are not integrals and depend on the origin of the coordinates. On lattices, they must share one MassSink.
class MassTotals {
 public:
  struct Sums;  // mass_totals.hpp

  /// The sums of the empty set.
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

/// Adds up mass properties of vertices as they come, without storing them.
///
/// The sums (Franklin, UNION3, section 4; weights in octants.hpp) are exact. On a lattice they are integers.
/// On ranks they are products of whole significands, with a sum for each exponent (exact.hpp).
class MassSink : public VertexSink {
 public:
  /// `axes` are the axes of the vertices. The sink keeps its own copy.
  explicit MassSink(Axes axes);
  ~MassSink() override;
  void add(std::span<const Vertex> vertices) override;

  /// Adds the sums of a region whose coordinates count from the ordinals `origin`. The regions must not
  /// overlap, and all axes must be lattices (otherwise Error(usage)). Thread-safe.
  void add(const LatticeSums& sums, const std::array<std::uint32_t, 3>& origin);
  /// Extends the bounds by ordinals that occur in the union. Needed only with LatticeSums. Thread-safe.
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
  // modulo 2^64, because only the final sum is known to fit
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

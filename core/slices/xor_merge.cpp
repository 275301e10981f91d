#include "core/slices/xor_merge.hpp"

#include <algorithm>

#include "boxunion/octants.hpp"

namespace boxunion {
namespace {

constexpr unsigned bit(unsigned quadrants, int i) {
  return quadrants >> i & 1u;
}
/// The quadrants below (bit 0) and above (bit 1) the line to the right of a vertex, repeated on both sides
/// for a later point.
constexpr unsigned beside(unsigned quadrants) {
  return bit(quadrants, 1) * 3u | bit(quadrants, 3) * 12u;
}
constexpr bool starts_horizontal(unsigned quadrants) {
  return bit(quadrants, 1) != bit(quadrants, 3);
}

/// The vertices of a contour with the same y as the first one.
std::span<const ContourVertex> first_row(std::span<const ContourVertex> contour) {
  std::size_t n = 0;
  while (n < contour.size() && contour[n].y == contour[0].y) ++n;
  return contour.first(n);
}

}  // namespace

XorMerge::XorMerge(std::uint32_t size) {
  for (Side& side : sides_) {
    side.edges = OrderedBitset(size);
    side.inside_right.resize((size + 63) / 64);
  }
}

/// The quadrants of the slab at a point of the line that is not one of its vertices. row[row_index - 1] is
/// the last vertex before the point.
unsigned XorMerge::Side::quadrants(std::uint32_t x, std::size_t row_index) const {
  if (row_index > 0) {
    const unsigned before = row[row_index - 1].quadrants;
    if (starts_horizontal(before)) return beside(before);
  }
  if (edges.contains(x)) return right_of(x) ? 10u : 5u;
  const std::uint32_t left = edges.below(x);
  return left != OrderedBitset::kNone && right_of(left) ? 15u : 0u;
}

/// Moves past the line. The vertical edges above it become active.
void XorMerge::Side::advance() {
  for (const ContourVertex& v : row) {
    if (bit(v.quadrants, 2) == bit(v.quadrants, 3)) {
      edges.erase(v.x);
      continue;
    }
    edges.insert(v.x);
    std::uint64_t& word = inside_right[v.x >> 6];
    const std::uint64_t mask = std::uint64_t{1} << (v.x & 63);
    word = bit(v.quadrants, 3) ? word | mask : word & ~mask;
  }
}

void XorMerge::emit(std::uint32_t x, std::uint32_t y, unsigned lower, unsigned upper) {
  const unsigned mask = lower | upper << 4;
  if (kOctants[mask].vertex) out_->push_back({x, y, z_, mask});
}

/// Finds where horizontal edges of one side on the line cross vertical edges of the other side.
void XorMerge::crossings(int horizontal) {
  const Side& side = sides_[horizontal];
  const Side& other = sides_[1 - horizontal];
  std::size_t next = 0;  // index in the other side's row, whose vertices are candidates already
  for (std::size_t i = 0; i + 1 < side.row.size(); ++i) {
    const ContourVertex& v = side.row[i];
    if (!starts_horizontal(v.quadrants)) continue;
    for (std::uint32_t x = other.edges.above(v.x); x < side.row[i + 1].x; x = other.edges.above(x)) {
      while (next < other.row.size() && other.row[next].x < x) ++next;
      if (next < other.row.size() && other.row[next].x == x) continue;
      const unsigned passing = other.right_of(x) ? 10u : 5u;
      if (horizontal == 0)
        emit(x, v.y, beside(v.quadrants), passing);
      else
        emit(x, v.y, passing, beside(v.quadrants));
    }
  }
}

void XorMerge::operator()(std::span<const ContourVertex> lower, std::span<const ContourVertex> upper,
                          std::uint32_t z, Array<Vertex>& out) {
  if (std::ranges::equal(lower, upper)) return;
  z_ = z;
  out_ = &out;
  std::span<const ContourVertex> rest[2] = {lower, upper};
  while (!rest[0].empty() || !rest[1].empty()) {
    const std::uint32_t y = rest[1].empty()   ? rest[0][0].y
                            : rest[0].empty() ? rest[1][0].y
                                              : std::min(rest[0][0].y, rest[1][0].y);
    for (int s = 0; s < 2; ++s) {
      const bool here = !rest[s].empty() && rest[s][0].y == y;
      sides_[s].row = here ? first_row(rest[s]) : std::span<const ContourVertex>{};
      rest[s] = rest[s].subspan(sides_[s].row.size());
    }
    const auto &a = sides_[0].row, &b = sides_[1].row;
    std::size_t i = 0, j = 0;
    while (i < a.size() || j < b.size()) {
      if (j == b.size() || (i < a.size() && a[i].x < b[j].x)) {
        emit(a[i].x, y, a[i].quadrants, sides_[1].quadrants(a[i].x, j));
        ++i;
      } else if (i == a.size() || b[j].x < a[i].x) {
        emit(b[j].x, y, sides_[0].quadrants(b[j].x, i), b[j].quadrants);
        ++j;
      } else {
        emit(a[i].x, y, a[i].quadrants, b[j].quadrants);
        ++i;
        ++j;
      }
    }
    crossings(0);
    crossings(1);
    sides_[0].advance();
    sides_[1].advance();
  }
}

}  // namespace boxunion

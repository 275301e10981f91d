#include "tests/support/reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "boxunion/octants.hpp"

namespace boxunion {
namespace {

/// The boxes of several sets, and the set of each box.
template <class Box>
struct Flat {
  explicit Flat(std::span<const std::vector<Box>> sets) {
    for (std::size_t set = 0; set < sets.size(); ++set)
      for (const Box& box : sets[set]) {
        boxes.push_back(box);
        bit.push_back(std::uint64_t{1} << set);
      }
  }
  std::vector<Box> boxes;
  std::vector<std::uint64_t> bit;
};

/// The grid through the faces of all boxes, and which of its voxels lie in the combination. Voxel i of an
/// axis lies between coordinates i and i + 1. Voxels outside the grid are empty.
template <class T>
class Grid {
 public:
  using Index = std::array<std::ptrdiff_t, 3>;
  std::array<std::vector<T>, 3> coordinates;

  /// The coordinates of box i are corner(i, axis) and corner(i, axis + 3). bit[i] is the bit of its set.
  template <class Corner>
  Grid(const std::vector<std::uint64_t>& bit, const Combination& combination, Corner&& corner) {
    const std::size_t boxes = bit.size();
    for (unsigned axis = 0; axis < 3; ++axis) {
      auto& line = coordinates[axis];
      for (std::size_t i = 0; i < boxes; ++i)
        for (const unsigned side : {0u, 3u}) line.push_back(corner(i, axis + side));
      std::sort(line.begin(), line.end());
      line.erase(std::unique(line.begin(), line.end()), line.end());
    }
    std::vector<std::uint64_t> sets(std::size_t(points(0) * points(1) * points(2)));
    for (std::size_t i = 0; i < boxes; ++i) {
      Index lo, hi;
      for (unsigned axis = 0; axis < 3; ++axis) {
        lo[axis] = position(axis, corner(i, axis));
        hi[axis] = position(axis, corner(i, axis + 3));
      }
      for (auto z = lo[2]; z < hi[2]; ++z)
        for (auto y = lo[1]; y < hi[1]; ++y)
          for (auto x = lo[0]; x < hi[0]; ++x) sets[offset({x, y, z})] |= bit[i];
    }
    for (const std::uint64_t s : sets) filled_.push_back(combination(s));
  }

  std::ptrdiff_t points(unsigned axis) const { return std::ssize(coordinates[axis]); }

  bool filled(Index voxel) const {
    for (unsigned axis = 0; axis < 3; ++axis)
      if (voxel[axis] < 0 || voxel[axis] + 1 >= points(axis)) return false;
    return filled_[offset(voxel)];
  }

  /// Calls f(index) for every grid point. A point is also the low corner of the voxel with the same index.
  template <class F>
  void each_point(F&& f) const {
    for (std::ptrdiff_t z = 0; z < points(2); ++z)
      for (std::ptrdiff_t y = 0; y < points(1); ++y)
        for (std::ptrdiff_t x = 0; x < points(0); ++x) f(Index{x, y, z});
  }

 private:
  std::ptrdiff_t position(unsigned axis, const T& coordinate) const {
    const auto& line = coordinates[axis];
    return std::lower_bound(line.begin(), line.end(), coordinate) - line.begin();
  }
  std::size_t offset(Index i) const { return std::size_t((i[2] * points(1) + i[1]) * points(0) + i[0]); }

  std::vector<bool> filled_;
};

template <class Index>
Index step_back(Index index, unsigned axis) {
  --index[axis];
  return index;
}

mpq_class power(const mpq_class& x, int n) {
  return n == 0 ? mpq_class(1) : mpq_class(x * power(x, n - 1));
}

/// The integral of (t - origin)^n over [lo, hi].
mpq_class integral(const mpq_class& lo, const mpq_class& hi, const mpq_class& origin, int n) {
  return (power(hi - origin, n + 1) - power(lo - origin, n + 1)) / (n + 1);
}

}  // namespace

Array<Vertex> brute_force_vertices(std::span<const OrdinalBox> boxes) {
  const std::vector<OrdinalBox> set(boxes.begin(), boxes.end());
  return brute_force_vertices({&set, 1}, [](std::uint64_t sets) { return sets != 0; });
}

Array<Vertex> brute_force_vertices(std::span<const std::vector<OrdinalBox>> sets,
                                   const Combination& combination) {
  const auto [boxes, bit] = Flat<OrdinalBox>(sets);
  const Grid<std::uint32_t> grid(bit, combination, [&boxes = boxes](std::size_t i, unsigned corner) {
    return corner < 3 ? boxes[i].lo[corner] : boxes[i].hi[corner - 3];
  });
  Array<Vertex> vertices;
  grid.each_point([&](auto p) {
    unsigned mask = 0;
    for (int octant = 0; octant < 8; ++octant)
      mask |= unsigned(grid.filled(
                  {p[0] - 1 + (octant & 1), p[1] - 1 + (octant >> 1 & 1), p[2] - 1 + (octant >> 2)}))
              << octant;
    if (kOctants[mask].vertex)
      vertices.push_back({grid.coordinates[0][std::size_t(p[0])], grid.coordinates[1][std::size_t(p[1])],
                          grid.coordinates[2][std::size_t(p[2])], mask});
  });
  return vertices;
}

MassProperties brute_force_mass(std::span<const Box> boxes) {
  const std::vector<Box> set(boxes.begin(), boxes.end());
  return brute_force_mass({&set, 1}, [](std::uint64_t sets) { return sets != 0; });
}

MassProperties brute_force_mass(std::span<const std::vector<Box>> sets, const Combination& combination) {
  std::vector<std::vector<Box>> thick(sets.begin(), sets.end());
  for (std::vector<Box>& set : thick)
    std::erase_if(set, [](const Box& b) { return b[0] == b[3] || b[1] == b[4] || b[2] == b[5]; });
  const Flat<Box> flat(thick);
  const Grid<mpq_class> grid(flat.bit, combination,
                             [&](std::size_t i, unsigned c) { return mpq_class(flat.boxes[i][c]); });
  using Index = Grid<mpq_class>::Index;
  const auto lo = [&](Index i, unsigned a) { return grid.coordinates[a][std::size_t(i[a])]; };
  const auto hi = [&](Index i, unsigned a) { return grid.coordinates[a][std::size_t(i[a] + 1)]; };
  // The integral of x^i * y^j * z^k over a voxel, about an origin.
  const auto moment = [&](Index v, const std::array<mpq_class, 3>& origin, std::array<int, 3> powers) {
    mpq_class product = 1;
    for (unsigned a = 0; a < 3; ++a) product *= integral(lo(v, a), hi(v, a), origin[a], powers[a]);
    return product;
  };

  MassProperties p;
  std::vector<Index> voxels;
  mpq_class area, length;
  grid.each_point([&](Index i) {
    if (grid.filled(i)) voxels.push_back(i);
    for (unsigned a = 0; a < 3; ++a) {
      const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
      const bool b_inside = i[b] + 1 < grid.points(b), c_inside = i[c] + 1 < grid.points(c);
      if (b_inside && c_inside && grid.filled(i) != grid.filled(step_back(i, a)))
        area += (hi(i, b) - lo(i, b)) * (hi(i, c) - lo(i, c));
      if (i[a] + 1 >= grid.points(a)) continue;
      // The four voxels around the grid edge that runs along a from here. It is an edge unless they are
      // constant along b or c.
      const bool q00 = grid.filled(step_back(step_back(i, b), c)), q10 = grid.filled(step_back(i, c));
      const bool q01 = grid.filled(step_back(i, b)), q11 = grid.filled(i);
      if ((q00 != q10 || q01 != q11) && (q00 != q01 || q10 != q11)) length += hi(i, a) - lo(i, a);
    }
    unsigned mask = 0;
    for (int octant = 0; octant < 8; ++octant)
      mask |= unsigned(grid.filled(
                  {i[0] - 1 + (octant & 1), i[1] - 1 + (octant >> 1 & 1), i[2] - 1 + (octant >> 2)}))
              << octant;
    p.vertices += kOctants[mask].vertex;
    p.extreme_vertices += std::popcount(mask) % 2;
  });
  p.area = round_to_nearest(area);
  p.edge_length = round_to_nearest(length);
  if (voxels.empty()) return p;

  mpq_class volume;
  std::array<mpq_class, 3> centroid;
  for (const Index& v : voxels) volume += moment(v, centroid, {0, 0, 0});
  std::array<mpq_class, 3> first;
  for (const Index& v : voxels) {
    first[0] += moment(v, centroid, {1, 0, 0});
    first[1] += moment(v, centroid, {0, 1, 0});
    first[2] += moment(v, centroid, {0, 0, 1});
  }
  for (unsigned a = 0; a < 3; ++a) centroid[a] = first[a] / volume;
  mpq_class xx, yy, zz, xy, yz, zx;
  for (const Index& v : voxels) {
    xx += moment(v, centroid, {2, 0, 0});
    yy += moment(v, centroid, {0, 2, 0});
    zz += moment(v, centroid, {0, 0, 2});
    xy += moment(v, centroid, {1, 1, 0});
    yz += moment(v, centroid, {0, 1, 1});
    zx += moment(v, centroid, {1, 0, 1});
  }
  p.volume = round_to_nearest(volume);
  for (unsigned a = 0; a < 3; ++a) {
    p.centroid[a] = round_to_nearest(centroid[a]);
    const auto [first, last] = std::ranges::minmax(voxels, {}, [a](const Index& v) { return v[a]; });
    p.bounds[0][a] = lo(first, a).get_d();
    p.bounds[1][a] = hi(last, a).get_d();
  }
  const double ixy = round_to_nearest(-xy), iyz = round_to_nearest(-yz), izx = round_to_nearest(-zx);
  p.inertia = {{{round_to_nearest(yy + zz), ixy, izx},
                {ixy, round_to_nearest(zz + xx), iyz},
                {izx, iyz, round_to_nearest(xx + yy)}}};
  return p;
}

double round_to_nearest(const mpq_class& value) {
  const mpq_class magnitude = abs(value);
  if (magnitude == 0) return 0;
  const auto scaled = [&](int exponent) {
    mpq_class result;
    if (exponent < 0)
      mpq_mul_2exp(result.get_mpq_t(), magnitude.get_mpq_t(), static_cast<mp_bitcnt_t>(-exponent));
    else
      mpq_div_2exp(result.get_mpq_t(), magnitude.get_mpq_t(), static_cast<mp_bitcnt_t>(exponent));
    return result;
  };
  // The exponent of the last digit: 53 digits, or fewer for subnormals.
  int exponent =
      int(mpz_sizeinbase(value.get_num_mpz_t(), 2)) - int(mpz_sizeinbase(value.get_den_mpz_t(), 2)) - 54;
  while (scaled(exponent) >= mpq_class(0x1p53)) ++exponent;
  exponent = std::max(exponent, -1074);
  const mpq_class digits = scaled(exponent);
  mpz_class rounded = digits.get_num() / digits.get_den();  // rounded down
  const int above_half = cmp(mpq_class(digits - rounded), mpq_class(1, 2));
  if (above_half > 0 || (above_half == 0 && mpz_odd_p(rounded.get_mpz_t()))) rounded += 1;
  return std::copysign(std::ldexp(rounded.get_d(), exponent), sgn(value));
}

std::ostream& operator<<(std::ostream& out, const MassProperties& p) {
  const auto row = [&](const char* name, const std::array<double, 3>& values) {
    out << name << values[0] << ' ' << values[1] << ' ' << values[2] << '\n';
  };
  const auto precision = out.precision(17);
  out << "vertices " << p.vertices << ", extreme " << p.extreme_vertices << '\n';
  row("from ", p.bounds[0]);
  row("to ", p.bounds[1]);
  out << "volume " << p.volume << ", area " << p.area << ", edge length " << p.edge_length << '\n';
  row("centroid ", p.centroid);
  for (const auto& inertia : p.inertia) row("inertia ", inertia);
  out.precision(precision);
  return out;
}

}  // namespace boxunion

#include "tests/boundary/boundary_reference.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace boxunion {
namespace {

using Index = Voxels::Index;

Index moved(Index i, int axis, int by) {
  i[std::size_t(axis)] += by;
  return i;
}

/// A partition of elements of any type, which can be joined into sets.
template <class Name>
class Sets {
 public:
  void add(const Name& name) { parents_.try_emplace(name, name); }
  bool has(const Name& name) const { return parents_.contains(name); }
  Name find(const Name& name) const {
    Name at = name;
    while (parents_.at(at) != at) at = parents_.at(at);
    return at;
  }
  void join(const Name& a, const Name& b) { parents_[find(a)] = find(b); }
  std::size_t count() const {
    return std::size_t(
        std::count_if(parents_.begin(), parents_.end(), [](const auto& p) { return p.first == p.second; }));
  }
  std::vector<Name> names() const {
    std::vector<Name> all;
    for (const auto& p : parents_) all.push_back(p.first);
    return all;
  }

 private:
  std::map<Name, Name> parents_;
};

/// A unit square: the filled voxel, and the direction 0 .. 5 (+x, -x, ...) in which its neighbor is empty.
using Square = std::pair<Index, int>;
/// A unit edge: its low end and its axis.
using Segment = std::pair<Index, int>;

}  // namespace

std::ostream& operator<<(std::ostream& out, const BoundaryCounts& c) {
  return out << "edges " << c.edges << " (" << c.nonmanifold_edges << " non-manifold), faces " << c.faces
             << ", holes " << c.holes << ", shells " << c.shells << ", bodies " << c.bodies;
}

Voxels::Voxels(std::span<const IntegerBox> boxes) {
  Index hi{};
  for (std::size_t a = 0; a < 3; ++a) {
    lo_[a] = std::numeric_limits<int>::max();
    hi[a] = std::numeric_limits<int>::min();
    for (const IntegerBox& box : boxes) {
      lo_[a] = std::min(lo_[a], box[a]);
      hi[a] = std::max(hi[a], box[a + 3]);
    }
    if (boxes.empty()) lo_[a] = hi[a] = 0;
    lo_[a] -= 1;
    size_[a] = hi[a] + 1 - lo_[a];
  }
  bodies_.assign(std::size_t(size_[0]) * std::size_t(size_[1]) * std::size_t(size_[2]), -1);
  std::set<Index> unvisited;
  for (const IntegerBox& b : boxes)
    for (int z = b[2]; z < b[5]; ++z)
      for (int y = b[1]; y < b[4]; ++y)
        for (int x = b[0]; x < b[3]; ++x) unvisited.insert({x, y, z});
  while (!unvisited.empty()) {
    std::vector<Index> stack = {*unvisited.begin()};
    unvisited.erase(unvisited.begin());
    while (!stack.empty()) {
      const Index at = stack.back();
      stack.pop_back();
      bodies_[offset(at)] = body_count_;
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1})
          if (const Index next = moved(at, axis, step); unvisited.erase(next) != 0) stack.push_back(next);
    }
    ++body_count_;
  }
}

std::size_t Voxels::offset(const Index& i) const {
  return (std::size_t(i[2] - lo_[2]) * std::size_t(size_[1]) + std::size_t(i[1] - lo_[1])) *
             std::size_t(size_[0]) +
         std::size_t(i[0] - lo_[0]);
}

bool Voxels::filled(const Index& low) const {
  for (std::size_t a = 0; a < 3; ++a)
    if (low[a] < lo_[a] || low[a] >= lo_[a] + size_[a]) return false;
  return bodies_[offset(low)] >= 0;
}

template <class F>
void Voxels::each(F&& f) const {
  for (int z = 0; z < size_[2]; ++z)
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x) f(Index{lo_[0] + x, lo_[1] + y, lo_[2] + z});
}

BoundaryCounts Voxels::count() const {
  BoundaryCounts counts;
  counts.bodies = std::size_t(body_count_);

  Sets<Square> faces, shells;
  each([&](const Index& at) {
    for (int d = 0; d < 6; ++d)
      if (filled(at) && !filled(moved(at, d / 2, d % 2 ? -1 : 1))) {
        faces.add({at, d});
        shells.add({at, d});
      }
  });

  // Faces: squares of one direction that share a side. A face is open, so its Euler number is 1 - holes.
  std::map<Square, long> euler;
  for (const Square& square : faces.names()) {
    const auto& [at, d] = square;
    for (const int axis : {(d / 2 + 1) % 3, (d / 2 + 2) % 3})
      if (const Square next = {moved(at, axis, 1), d}; faces.has(next)) faces.join(square, next);
  }
  for (const Square& square : faces.names()) {
    const auto& [at, d] = square;
    const int u = (d / 2 + 1) % 3, v = (d / 2 + 2) % 3;
    const bool right = faces.has({moved(at, u, 1), d}), above = faces.has({moved(at, v, 1), d});
    const bool across = faces.has({moved(moved(at, u, 1), v, 1), d});
    euler[faces.find(square)] += 1 - right - above + (right && above && across);
  }
  counts.faces = euler.size();
  for (const auto& [face, number] : euler) counts.holes += std::size_t(1 - number);

  // Edges: take the four voxels around a unit edge in cyclic order. Squares that bound the same run of filled
  // voxels belong to one shell. Unit edges are joined if the voxels on both sides of the point between them
  // are the same.
  Sets<Segment> edges;
  std::map<Segment, std::array<bool, 4>> kinds;
  each([&](const Index& at) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const std::array<Index, 4> round = {at, moved(at, u, -1), moved(moved(at, u, -1), v, -1),
                                          moved(at, v, -1)};
      std::array<bool, 4> full;
      for (std::size_t i = 0; i < 4; ++i) full[i] = filled(round[i]);
      const auto square = [&](std::size_t from, std::size_t to) {
        for (int d = 0;; ++d)
          if (moved(round[from], d / 2, d % 2 ? -1 : 1) == round[to]) return Square{round[from], d};
      };
      int changes = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        changes += full[i] != full[(i + 1) % 4];
        if (full[i] || !full[(i + 1) % 4]) continue;
        std::size_t last = (i + 1) % 4;
        while (full[(last + 1) % 4]) last = (last + 1) % 4;
        shells.join(square((i + 1) % 4, i), square(last, (last + 1) % 4));
      }
      if (changes == 0 || (changes == 2 && full[0] + full[1] + full[2] + full[3] == 2)) continue;
      edges.add({at, axis});
      kinds[{at, axis}] = full;
    }
  });
  for (const Segment& segment : edges.names()) {
    const Segment next = {moved(segment.first, segment.second, 1), segment.second};
    if (edges.has(next) && kinds[segment] == kinds[next]) edges.join(segment, next);
  }
  for (const Segment& segment : edges.names())
    if (edges.find(segment) == segment) {
      const std::array<bool, 4>& full = kinds[segment];
      ++counts.edges;
      counts.nonmanifold_edges += full[0] != full[1] && full[1] != full[2] && full[2] != full[3];
    }
  counts.shells = shells.count();
  return counts;
}

}  // namespace boxunion

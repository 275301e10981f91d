#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/contour.hpp"
#include "boxunion/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/radix_sort.hpp"
#include "core/boundary/planes.hpp"
#include "core/plane/contour_links.hpp"

namespace boxunion {
namespace {

constexpr std::uint8_t kUp = 4;  // direction of faces

bool fills(const ContourVertex& vertex, Quadrant quadrant) {
  return vertex.quadrants >> quadrant & 1u;
}

/// A hole that was cut off a loop where the loop touched itself.
struct CutOff {
  std::uint32_t loop;                  // index in the band
  std::vector<std::uint32_t> corners;  // from the lowest corner on, the leftmost of these
};

/// The loops that begin in a band, in the order of their beginnings. No loop visits a vertex twice.
struct BandLoops {
  Array<std::uint32_t> corners;      // of all loops, one after the other
  Array<std::uint32_t> ends;         // of each loop in `corners`
  std::vector<std::uint32_t> holes;  // indices of the loops that are holes
  std::vector<CutOff> cut_off;       // in the order of their loops

  std::size_t size() const { return ends.size(); }
  std::size_t polygons() const { return ends.size() - holes.size(); }
  std::span<const std::uint32_t> operator[](std::size_t loop) const {
    const std::uint32_t begin = loop == 0 ? 0 : ends[loop - 1];
    return std::span(corners).subspan(begin, ends[loop] - begin);
  }
};

/// Cuts the last loop of a band, from `begin` on, wherever it visits a vertex twice. The part between the two
/// visits is a loop of its own. It is a hole, because loops of different polygons share no corner, and the
/// lowest corner of an outer loop is visited once. The remaining corners keep their order. Loops touch but
/// never cross themselves, so visits of different vertices are nested, and a stack finds them.
void cut_where_touching(const ContourLinks& links, std::size_t begin, BandLoops& loops) {
  std::vector<std::pair<std::uint32_t, std::size_t>> visits;  // vertex, place in the loop
  for (std::size_t i = begin; i < loops.corners.size(); ++i)
    if (links.touches(loops.corners[i])) visits.emplace_back(links.vertex(loops.corners[i]), i);
  std::ranges::sort(visits);
  std::vector<std::pair<std::size_t, std::size_t>> twice;  // places of the second and the first visit
  for (std::size_t i = 1; i < visits.size(); ++i)
    if (visits[i - 1].first == visits[i].first) twice.emplace_back(visits[i].second, visits[i - 1].second);
  if (twice.empty()) return;
  std::ranges::sort(twice);

  const std::vector<std::uint32_t> all(loops.corners.begin() + static_cast<std::ptrdiff_t>(begin),
                                       loops.corners.end());
  loops.corners.resize(begin);
  std::vector<std::size_t> stack;  // places not yet cut off
  auto next = twice.begin();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (next != twice.end() && next->first == begin + i) {
      const auto first = std::ranges::lower_bound(stack, next->second - begin);
      CutOff hole{static_cast<std::uint32_t>(loops.ends.size()), {}};
      for (auto place = first; place != stack.end(); ++place) hole.corners.push_back(all[*place]);
      const auto lowest = std::ranges::min_element(
          hole.corners, {}, [&](std::uint32_t corner) { return links.vertex(corner); });
      std::rotate(hole.corners.begin(), lowest, hole.corners.end());
      loops.cut_off.push_back(std::move(hole));
      stack.erase(first, stack.end());
      ++next;
    }
    stack.push_back(i);
  }
  for (const std::size_t place : stack) loops.corners.push_back(all[place]);
}

/// Follows the loops that begin in a band. A loop that comes from a lower band is abandoned as soon as that
/// shows. Corners of the band are marked when they are passed, so that none is passed twice.
BandLoops trace(const Contour& contour, const ContourLinks& links, const ContourLinks::Band& band) {
  const std::uint32_t n = static_cast<std::uint32_t>(contour.vertices.size()), size = band.end - band.begin;
  BandLoops loops;
  with_memory("the loops", size * sizeof(std::uint32_t), [&] { loops.corners.reserve(size); });
  loops.ends.reserve(band.beginnings.size());
  std::vector<std::uint64_t> passed(size / 32 + 1);  // two bits per vertex: its own corner and the upper one
  for (const std::uint32_t first : band.beginnings) {
    const std::size_t begin = loops.corners.size();
    std::uint32_t corner = first;
    bool has_upper = false;
    for (;; corner = links.next(corner)) {
      const std::uint32_t vertex = links.vertex(corner), place = vertex - band.begin;
      if (place < size) {
        std::uint64_t& word = passed[place / 32];
        const std::uint64_t bit = std::uint64_t{corner == vertex ? 1u : 2u} << place % 32 * 2;
        if (word & bit) break;
        word |= bit;
      } else if (vertex < band.begin) {
        break;
      }
      loops.corners.push_back(corner);
      has_upper |= corner != vertex;
    }
    if (loops.corners.size() == begin) continue;
    if (corner != first) {
      loops.corners.resize(begin);
      continue;
    }
    const bool is_hole = first < n && !fills(contour.vertices[first], right_above);
    if (is_hole) loops.holes.push_back(static_cast<std::uint32_t>(loops.ends.size()));
    if (has_upper) cut_where_touching(links, begin, loops);
    loops.ends.push_back(static_cast<std::uint32_t>(loops.corners.size()));
  }
  return loops;
}

/// How many more left ends of intervals a column has above a vertex than below, by the quadrants of the
/// vertex.
constexpr auto kLeftEnds = [] {
  std::array<std::int32_t, 16> change{};
  for (unsigned q = 0; q < 16; ++q)
    change[q] = int((q >> right_above & 1u) > (q >> left_above & 1u)) -
                int((q >> right_below & 1u) > (q >> left_below & 1u));
  return change;
}();

/// The left ends of the intervals in which a row cuts polygons, by column. They are kept in a bitmap, with
/// counts for blocks of it, because they change often.
class LeftEnds {
 public:
  explicit LeftEnds(std::uint32_t columns)
      : words_(columns / 64 + 1), blocks_(columns / kBlock + 1), corners_(columns) {}
  /// The left ends above a band.
  LeftEnds(const Contour& contour, const ContourLinks& links, const ContourLinks::Band& band)
      : LeftEnds(static_cast<std::uint32_t>(band.last.size())) {
    for (std::uint32_t column = 0; column < band.last.size(); ++column) {
      const std::uint32_t corner = band.last[column];
      if (corner == ContourLinks::kNone) continue;
      const ContourVertex& vertex = contour.vertices[links.vertex(corner)];
      if (fills(vertex, right_above) && !fills(vertex, left_above)) change(column, 1, corner);
    }
  }

  /// Changes the left end of a column, which then comes from `corner`.
  void change(std::uint32_t column, std::int32_t change, std::uint32_t corner) {
    words_[column / 64] ^= std::uint64_t(change != 0) << column % 64;
    blocks_[column / kBlock] += change;
    corners_[column] = corner;
  }
  /// The corner from which the last left end before a column comes. There must be one.
  std::uint32_t below(std::uint32_t column) const {
    std::uint32_t word = column / 64;
    std::uint64_t bits = words_[word] & ((std::uint64_t{1} << column % 64) - 1);
    while (bits == 0) {
      if (word % kWords == 0)
        while (blocks_[word / kWords - 1] == 0) word -= kWords;
      bits = words_[--word];
    }
    return corners_[word * 64 + 63 - static_cast<std::uint32_t>(std::countl_zero(bits))];
  }

 private:
  static constexpr std::uint32_t kBlock = 4096, kWords = kBlock / 64;

  std::vector<std::uint64_t> words_;
  std::vector<std::int32_t> blocks_;
  Array<std::uint32_t> corners_;
};

/// A loop round a hole.
struct Hole {
  std::uint32_t polygon;  // the polygon that has the hole
  std::span<const std::uint32_t> corners;
};

/// For each hole, the left end of the interval that it splits: a corner of a loop of the same polygon that
/// begins lower.
std::vector<std::uint32_t> find_left_ends(const Contour& contour, const ContourColumns& columns,
                                          const ContourLinks& links, std::span<const Hole> holes) {
  const std::span<const ContourLinks::Band> bands = links.bands();
  std::vector<std::uint32_t> result(holes.size());
  // to begin at a band costs as much as to pass some vertices per column
  const std::size_t grain = 4 * bands.size() * columns.count() / contour.vertices.size() + 1;
  parallel_ranges(0, bands.size(), grain, [&](std::size_t begin, std::size_t end) {
    const auto first = [&](std::uint32_t vertex) {  // the first hole that begins there or later
      return std::ranges::lower_bound(holes, vertex, {}, [](const Hole& hole) { return hole.corners[0]; });
    };
    std::uint32_t i = bands[begin].begin;
    const auto last = first(bands[end - 1].end);
    auto hole = first(i);
    if (hole == last) return;
    LeftEnds left_ends = begin == 0 ? LeftEnds(columns.count()) : LeftEnds(contour, links, bands[begin - 1]);
    for (; hole != last; ++hole) {
      for (const std::uint32_t lowest = hole->corners[0]; i < lowest; ++i) {
        const std::uint32_t quadrants = contour.vertices[i].quadrants;
        left_ends.change(columns[i], kLeftEnds[quadrants], quadrants == kRising ? links.upper(i) : i);
      }
      result[static_cast<std::size_t>(hole - holes.begin())] = left_ends.below(columns[i]);
    }
  });
  return result;
}

/// The holes, sorted by polygon and by their lowest vertices. Overwrites links with labels of their corners:
/// the polygon of an outer loop, or a hole.
std::vector<Hole> find_holes(const Contour& contour, const ContourColumns& columns, ContourLinks& links,
                             std::span<const BandLoops> bands) {
  constexpr std::uint32_t kHole = 0x80000000u;
  std::vector<Hole> holes;
  std::vector<std::array<std::uint32_t, 2>> before;  // polygons and holes in the bands below each
  std::uint32_t polygons = 0;
  bool some_cut_off = false;
  for (const BandLoops& band : bands) {
    some_cut_off |= !band.cut_off.empty();
    before.push_back({polygons, static_cast<std::uint32_t>(holes.size())});
    for (const std::uint32_t hole : band.holes) holes.push_back({0, band[hole]});
    polygons += static_cast<std::uint32_t>(band.polygons());
  }
  if (holes.empty() && !some_cut_off) return holes;
  const std::vector<std::uint32_t> left_ends = find_left_ends(contour, columns, links, holes);
  parallel_for_each(0, bands.size(), 1, [&](std::size_t b) {
    auto [polygon, hole] = before[b];
    auto own = bands[b].holes.begin();
    auto cut_off = bands[b].cut_off.begin();
    for (std::size_t l = 0; l < bands[b].size(); ++l) {
      const bool is_hole = own != bands[b].holes.end() && *own == l;
      own += is_hole;
      const std::uint32_t label = is_hole ? kHole | hole++ : polygon++;
      for (const std::uint32_t corner : bands[b][l]) links.next(corner) = label;
      for (; cut_off != bands[b].cut_off.end() && cut_off->loop == l; ++cut_off)
        for (const std::uint32_t corner : cut_off->corners) links.next(corner) = label;
    }
  });
  for (std::size_t i = 0; i < holes.size(); ++i) {
    const std::uint32_t beside = links.next(left_ends[i]);
    holes[i].polygon = beside < kHole ? beside : holes[beside - kHole].polygon;
  }
  if (some_cut_off) {
    for (const BandLoops& band : bands)
      for (const CutOff& hole : band.cut_off) {
        const std::uint32_t of = links.next(hole.corners[0]);
        holes.push_back({of < kHole ? of : holes[of - kHole].polygon, hole.corners});
      }
    std::ranges::sort(holes, {}, [&](const Hole& hole) { return links.vertex(hole.corners[0]); });
  }
  radix_sort(std::span(holes), [](const Hole& hole) { return hole.polygon; });
  return holes;
}

/// Joins the polygons with their holes, which are sorted by polygon.
Faces joined(const ContourLinks& links, std::span<const BandLoops> bands, std::span<const Hole> holes) {
  struct Place {
    std::size_t polygon = 0, hole = 0, point = 0;
  };
  std::vector<Place> before(bands.size() + 1);
  for (std::size_t b = 0; b < bands.size(); ++b) {
    Place place = before[b];
    place.polygon += bands[b].polygons();
    place.point += bands[b].corners.size();
    for (const std::uint32_t hole : bands[b].holes) place.point -= bands[b][hole].size();
    for (; place.hole < holes.size() && holes[place.hole].polygon < place.polygon; ++place.hole)
      place.point += holes[place.hole].corners.size();
    before[b + 1] = place;
  }
  const Place& all = before.back();
  Faces faces;
  with_memory("the polygons", all.point * sizeof(std::uint32_t), [&] {
    faces.loop_points.resize(all.point);
    faces.first_point.resize(all.polygon + all.hole + 1);
    faces.first_loop.resize(all.polygon + 1);
    faces.direction.resize(all.polygon);
  });
  std::ranges::fill(faces.direction, kUp);
  parallel_for_each(0, bands.size(), 1, [&](std::size_t b) {
    auto at = before[b];
    const auto append = [&](std::span<const std::uint32_t> corners) {
      for (const std::uint32_t corner : corners) faces.loop_points[at.point++] = links.vertex(corner);
      faces.first_point[at.polygon + at.hole + 1] = static_cast<std::uint32_t>(at.point);
    };
    std::size_t own_hole = 0;
    for (std::uint32_t l = 0; l < bands[b].size(); ++l) {
      if (own_hole < bands[b].holes.size() && bands[b].holes[own_hole] == l) {
        ++own_hole;
        continue;
      }
      append(bands[b][l]);
      for (++at.polygon; at.hole < holes.size() && holes[at.hole].polygon + 1 == at.polygon; ++at.hole)
        append(holes[at.hole].corners);
      faces.first_loop[at.polygon] = static_cast<std::uint32_t>(at.polygon + at.hole);
    }
  });
  return faces;
}

}  // namespace

Faces find_polygons(const Contour& contour) {
  constexpr std::size_t kMost = 0x7fffffff;  // a vertex may have two corners
  if (contour.vertices.size() > kMost)
    throw Error(ErrorKind::resources, "the contour has more than 2^31 - 1 vertices");
  const ContourColumns columns(contour);
  ContourLinks links(contour, columns);
  Interruptible::check();
  std::vector<BandLoops> bands(links.bands().size());
  parallel_for_each(0, bands.size(), 1,
                    [&](std::size_t b) { bands[b] = trace(contour, links, links.bands()[b]); });
  Interruptible::check();
  const std::vector<Hole> holes = find_holes(contour, columns, links, bands);
  return joined(links, bands, holes);
}

}  // namespace boxunion

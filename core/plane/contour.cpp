#include "boxunion/contour.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/base/counting_sort.hpp"
#include "core/base/memory.hpp"
#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/plane/contour_cell.hpp"
#include "core/solid/mass_sink.hpp"

namespace boxunion {
namespace {

/// Cuts the ordinals of an axis into parts of equal lengths, as far as possible.
class EqualParts {
 public:
  static constexpr double kMostParts = 1 << 15;

  EqualParts(std::uint32_t count, double parts)
      : count_(count),
        parts_(static_cast<std::uint32_t>(std::clamp(parts, 1., std::min(double(count), kMostParts)))),
        scale_((std::uint64_t{parts_} << 32) / count) {}

  std::uint32_t parts() const { return parts_; }
  /// The part that owns an ordinal.
  std::uint32_t part(std::uint32_t ordinal) const {
    return static_cast<std::uint32_t>((ordinal - 1) * scale_ >> 32);
  }
  /// The least ordinal of a part. begin(parts()) is beyond all ordinals.
  std::uint32_t begin(std::uint32_t part) const {
    const std::uint64_t before = ((std::uint64_t{part} << 32) + scale_ - 1) / scale_;
    return part == parts_ ? count_ + 1
                          : static_cast<std::uint32_t>(std::min<std::uint64_t>(before, count_)) + 1;
  }

 private:
  std::uint32_t count_, parts_;
  std::uint64_t scale_;  // parts / count, times 2^32
};

/// A grid of cells. A row of cells is a strip of the plane.
struct Grid {
  EqualParts columns, strips;
  double touched;  // average number of cells that a rectangle touches
};

/// Chooses cells that fit a bitmap. If there are enough rectangles to fill them, cells are so small that
/// every ordinal is a place of the bitmap. Otherwise their size is such that their rectangles have few
/// coordinates. Whole strips are cells if they need not be so low that many rectangles touch several of them.
/// On average, a rectangle touches few strips and few columns.
Grid make_grid(std::span<const OrdinalRectangle> all, const PlaneAxes& axes) {
  constexpr double kDirect = 62, kFewest = 2, kPlaces = 22, kFlatPlaces = 18, kMostTouched = 8;
  const double n = double(all.size()), extent[2] = {double(axes[0].count()), double(axes[1].count())};
  double sum[2] = {0, 0}, sampled = 0;
  Sample(all.size(), 256).each([&](std::size_t i) {
    ++sampled;
    for (const unsigned axis : {0u, 1u}) sum[axis] += all[i].hi[axis] - all[i].lo[axis];
  });
  double most[2], share[2];  // fraction of the extent of a rectangle
  for (const unsigned axis : {0u, 1u}) {
    share[axis] = sum[axis] / sampled / extent[axis];
    most[axis] = (kMostTouched - 1) / share[axis] + 1;
  }
  const auto grid = [&](double columns, double strips) {
    return Grid{{axes[0].count(), columns},
                {axes[1].count(), strips},
                (1 + share[0] * columns) * (1 + share[1] * strips)};
  };
  const double direct[2] = {std::ceil(extent[0] / kDirect), std::ceil(extent[1] / kDirect)};
  if (n >= kFewest * direct[0] * direct[1] && direct[0] <= most[0] && direct[1] <= most[1])
    return grid(direct[0], direct[1]);
  // A strip that is one cell needs no sort. It must be low to have few coordinates. On average, `crossing` of
  // the rectangles that it touches come up from below.
  const double crossing = n * share[1], flat = std::ceil(n / (kFlatPlaces - crossing));
  if (crossing <= 0.4 * kFlatPlaces && flat <= EqualParts::kMostParts) return grid(1, flat);
  // m rectangles owned by a cell have about 2 * (m + sqrt(m * density)) places on an axis
  const double density = n * share[0] * share[1];
  const double root = (std::sqrt(density + 4 * kPlaces) - std::sqrt(density)) / 2;
  const double cells = n / (root * root), ratio = std::clamp(share[1] / share[0], 1 / 16., 16.);
  const double columns = std::min(std::ceil(std::sqrt(cells * ratio)), most[0]);
  const double strips = std::min(std::ceil(cells / columns), most[1]);
  return grid(std::min(std::ceil(cells / strips), most[0]), strips);
}

/// The rectangles by parts. A part is some neighboring strips.
class Parts {
 public:
  /// Makes parts of `rectangles` rectangles on average, but no more parts than strips.
  Parts(Array<OrdinalRectangle> all, const EqualParts& strips, std::size_t rectangles)
      : strips_(strips.parts()),
        count_(std::clamp(all.size() / rectangles, std::size_t{1}, strips_)),
        first_(count_ + 1) {
    if (count_ == 1) {
      first_[1] = all.size();
      rectangles_ = std::move(all);
    } else {
      distribute(all, strips);
    }
  }

  std::size_t size() const { return count_; }
  std::span<const OrdinalRectangle> operator[](std::size_t part) const {
    return std::span(rectangles_).subspan(first_[part], first_[part + 1] - first_[part]);
  }
  /// The first strip of a part. first_strip(size()) is beyond all strips.
  std::uint32_t first_strip(std::size_t part) const {
    return static_cast<std::uint32_t>((part * strips_ + count_ - 1) / count_);
  }

 private:
  void distribute(std::span<const OrdinalRectangle> all, const EqualParts& strips) {
    constexpr std::size_t kChunk = 1 << 13, kMostChunks = 16;
    std::vector<std::uint32_t> part(strips_);
    for (std::uint32_t p = 0; p < count_; ++p)
      std::fill(part.begin() + first_strip(p), part.begin() + first_strip(p + 1), p);
    const std::size_t chunks = std::clamp(all.size() / kChunk, std::size_t{1}, kMostChunks);
    const auto parts_of = [&](std::size_t i, auto&& f) {
      const std::uint32_t to = part[strips.part(all[i].hi[1])];
      for (std::uint32_t p = part[strips.part(all[i].lo[1])]; p <= to; ++p) f(p);
    };
    CountingSort<std::size_t, decltype(parts_of)> sorting(all.size(), count_, chunks, parts_of);
    with_memory("the rectangles by strips", sorting.size() * sizeof(OrdinalRectangle),
                [&] { rectangles_.resize(sorting.size()); });
    sorting.scatter([&](std::size_t i, std::size_t place) { rectangles_[place] = all[i]; });
    std::ranges::copy(sorting.ends(), first_.begin() + 1);
  }

  std::size_t strips_, count_;
  std::vector<std::size_t> first_;
  Array<OrdinalRectangle> rectangles_;
};

/// Sorts vertices by row. Vertices of one row must be sorted already.
class RowSort {
 public:
  /// Sorts vertices in rows [lo, hi).
  void sort(std::span<ContourVertex> vertices, std::uint32_t lo, std::uint32_t hi) {
    constexpr int kFewest = 6;  // bits of a digit
    const int width = std::bit_width(hi - lo - 1),
              passes = std::max(1, (width - 1) / std::max(kFewest, int(std::bit_width(vertices.size()))) + 1),
              digit = (width + passes - 1) / passes;
    scratch_.resize(std::max(scratch_.size(), vertices.size()));
    std::span<ContourVertex> from = vertices, to = std::span(scratch_).first(vertices.size());
    for (int pass = 0; pass < passes; ++pass, std::swap(from, to))
      distribute(from, to, lo, pass * digit, digit);
    if (passes % 2 == 1) std::ranges::copy(from, to.begin());
  }

 private:
  void distribute(std::span<const ContourVertex> from, std::span<ContourVertex> to, std::uint32_t lo,
                  int shift, int digit) {
    const auto mask = static_cast<std::uint32_t>((std::uint64_t{1} << digit) - 1);
    place_.assign(std::size_t{mask} + 2, 0);
    std::size_t* const place = place_.data();
    for (const ContourVertex& v : from) ++place[((v.y - lo) >> shift & mask) + 1];
    std::inclusive_scan(place_.begin(), place_.end(), place_.begin());
    for (const ContourVertex& v : from) to[place[(v.y - lo) >> shift & mask]++] = v;
  }

  Array<ContourVertex> scratch_;
  std::vector<std::size_t> place_;  // of the next vertex of each digit
};

/// Finds the vertices of one part at a time.
class PartContour {
 public:
  explicit PartContour(const Grid& grid) : grid_(grid) {}

  /// The sorted vertices in strips [begin, end). `part` has all rectangles that touch these strips.
  Array<ContourVertex> find(std::span<const OrdinalRectangle> part, std::uint32_t begin, std::uint32_t end) {
    const EqualParts &columns = grid_.columns, &strips = grid_.strips;
    bin(part, begin, end);
    Array<ContourVertex> vertices;
    vertices.reserve(4 * part.size() + ContourCell::kMost);  // rarely more
    std::size_t cell = 0;
    for (std::uint32_t strip = begin; strip < end; ++strip) {
      Interruptible::check();
      const std::size_t first = vertices.size();
      bool is_sorted = true;
      for (std::uint32_t column = 0; column < columns.parts(); ++column, ++cell) {
        const std::span rectangles =
            std::span(binned_).subspan(first_[cell], first_[cell + 1] - first_[cell]);
        if (rectangles.empty() || covered_[cell]) continue;
        is_sorted &= vertices.size() == first;
        is_sorted &= cell_.find({{columns.begin(column), strips.begin(strip)},
                                 {columns.begin(column + 1), strips.begin(strip + 1)}},
                                rectangles, vertices);
      }
      if (!is_sorted)
        sort_.sort(std::span(vertices).subspan(first), strips.begin(strip), strips.begin(strip + 1));
    }
    if (vertices.size() < vertices.capacity() / 4) vertices.shrink_to_fit();
    return vertices;
  }

 private:
  /// The cells that a rectangle touches.
  struct Touched {
    std::uint16_t left, right, below, above;
  };

  /// Puts rectangles into the cells that they touch, and marks cells that one rectangle covers.
  void bin(std::span<const OrdinalRectangle> part, std::uint32_t begin, std::uint32_t end) {
    const EqualParts &columns = grid_.columns, &strips = grid_.strips;
    const std::size_t width = columns.parts();
    covered_.assign((end - begin) * width, 0);
    first_.assign((end - begin) * width + 1, 0);
    touched_.resize(part.size());
    for (std::size_t i = 0; i < part.size(); ++i) {
      const OrdinalRectangle& r = part[i];
      const std::uint32_t left = columns.part(r.lo[0]), right = columns.part(r.hi[0]),
                          lowest = strips.part(r.lo[1]), highest = strips.part(r.hi[1]),
                          below = std::max(lowest, begin), above = std::min(highest, end - 1);
      touched_[i] = {static_cast<std::uint16_t>(left), static_cast<std::uint16_t>(right),
                     static_cast<std::uint16_t>(below - begin), static_cast<std::uint16_t>(above - begin)};
      for (std::uint32_t strip = below; strip <= above; ++strip) {
        std::size_t* const cell = first_.data() + (strip - begin) * width;
        for (std::uint32_t column = left; column <= right; ++column) ++cell[column];
        if (lowest < strip && strip < highest && left + 1 < right)
          std::fill_n(covered_.data() + (strip - begin) * width + left + 1, right - left - 1, 1);
      }
    }
    std::inclusive_scan(first_.begin(), first_.end(), first_.begin());
    binned_.resize(first_.back());
    for (std::size_t i = 0; i < part.size(); ++i) {
      const auto [left, right, below, above] = touched_[i];
      for (std::uint32_t strip = below; strip <= above; ++strip) {
        std::size_t* const cell = first_.data() + strip * width;
        for (std::uint32_t column = left; column <= right; ++column) binned_[--cell[column]] = part[i];
      }
    }
  }

  Grid grid_;
  ContourCell cell_;
  RowSort sort_;
  std::vector<std::size_t> first_;  // by cell: its first rectangle in binned_
  std::vector<std::uint8_t> covered_;
  Array<Touched> touched_;
  Array<OrdinalRectangle> binned_;
};

/// The vertices of each part.
std::vector<Array<ContourVertex>> find_parts(Array<OrdinalRectangle> all, const PlaneAxes& axes) {
  constexpr double kPart = 1 << 13;  // rectangles in cells that are worth another part and thread
  const Grid grid = make_grid(all, axes);
  const Parts parts(std::move(all), grid.strips, static_cast<std::size_t>(kPart / grid.touched) + 1);
  PerThread<PartContour> finders{PartContour(grid)};
  std::vector<Array<ContourVertex>> found(parts.size());
  parallel_for_each(0, parts.size(), 1, [&](std::size_t i) {
    found[i] = finders.local().find(parts[i], parts.first_strip(i), parts.first_strip(i + 1));
  });
  return found;
}

Array<ContourVertex> joined(std::vector<Array<ContourVertex>> parts) {
  if (parts.size() == 1) return std::move(parts[0]);
  std::vector<std::size_t> first(parts.size() + 1);
  for (std::size_t i = 0; i < parts.size(); ++i) first[i + 1] = first[i] + parts[i].size();
  Array<ContourVertex> all;
  with_memory("the contour", first.back() * sizeof(ContourVertex), [&] { all.resize(first.back()); });
  parallel_for_each(0, parts.size(), parts.size() / 64 + 1, [&](std::size_t i) {
    std::ranges::copy(parts[i], all.begin() + std::ptrdiff_t(first[i]));
  });
  return all;
}

}  // namespace

Contour find_contour(const RectangleSet& rectangles) {
  validate(rectangles);
  PlaneOrdinals ordinals = make_ordinals(rectangles);
  Contour contour{std::move(ordinals.axes), {}};
  if (!ordinals.rectangles.empty())
    contour.vertices = joined(find_parts(std::move(ordinals.rectangles), contour.axes));
  return contour;
}

// The contour is taken as the lower plane of a solid, at z = 0, where only the area and the edges of that
// plane count. Ordinal 0 is used because sums on lattices count from it.
ContourProperties measure(const Contour& contour) {
  constexpr std::size_t kBatch = 1 << 12;
  MassSink sink({contour.axes[0], contour.axes[1], Axis::lattice(0, 0, 1)});
  parallel_ranges(0, contour.vertices.size(), kBatch, [&](std::size_t begin, std::size_t end) {
    std::vector<Vertex> batch;
    for (std::size_t i = begin; i < end; ++i) {
      const ContourVertex& v = contour.vertices[i];
      batch.push_back({v.x, v.y, 0, v.quadrants << 4});
    }
    sink.add(batch);
  });
  const MassProperties mass = sink.result();
  return {mass.area, mass.edge_length};
}

}  // namespace boxunion

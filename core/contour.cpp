#include "core/contour.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/mass.hpp"
#include "core/parallel.hpp"

namespace boxunion {
namespace {

/// Cuts the ordinals of an axis into parts of equal lengths, as far as possible.
class Cuts {
 public:
  Cuts(std::uint32_t count, double parts)
      : count_(count),
        parts_(static_cast<std::uint32_t>(std::clamp(parts, 1., std::min(double(count), kMostParts)))),
        scale_((std::uint64_t{parts_} << 32) / count) {}

  std::uint32_t parts() const { return parts_; }
  /// The part that owns an ordinal.
  std::uint32_t part(std::uint32_t ordinal) const {
    return static_cast<std::uint32_t>((ordinal - 1) * scale_ >> 32);
  }
  /// The least ordinal of a part; of part parts(), one beyond all.
  std::uint32_t begin(std::uint32_t part) const {
    const std::uint64_t before = ((std::uint64_t{part} << 32) + scale_ - 1) / scale_;
    return part == parts_ ? count_ + 1
                          : static_cast<std::uint32_t>(std::min<std::uint64_t>(before, count_)) + 1;
  }

 private:
  static constexpr double kMostParts = 1 << 15;

  std::uint32_t count_, parts_;
  std::uint64_t scale_;  // parts / count, times 2^32
};

/// A grid of cells, row by row: strips of the plane.
struct Grid {
  Cuts columns, strips;
};

/// Chooses cells that a bitmap has room for: so small that all ordinals are places of its bits if there are
/// rectangles enough to fill them, else of such a size that their rectangles have few coordinates. A
/// rectangle touches not many strips nor columns on average.
Grid make_grid(std::span<const OrdinalRectangle> all, const PlaneAxes& axes) {
  constexpr double kDirect = 62, kFewest = 2, kPlaces = 22, kMostTouched = 8;
  const double n = double(all.size()), extent[2] = {double(axes[0].count()), double(axes[1].count())};
  double sum[2] = {0, 0}, sampled = 0;
  for (std::size_t i = 0; i < all.size(); i += all.size() / 1024 + 1, ++sampled)
    for (const unsigned axis : {0u, 1u}) sum[axis] += all[i].hi[axis] - all[i].lo[axis];
  double most[2], share[2];  // of the extent, that a rectangle takes
  for (const unsigned axis : {0u, 1u}) {
    share[axis] = sum[axis] / sampled / extent[axis];
    most[axis] = (kMostTouched - 1) / share[axis] + 1;
  }
  const auto grid = [&](double columns, double strips) {
    return Grid{{axes[0].count(), columns}, {axes[1].count(), strips}};
  };
  const double direct[2] = {std::ceil(extent[0] / kDirect), std::ceil(extent[1] / kDirect)};
  if (n >= kFewest * direct[0] * direct[1] && direct[0] <= most[0] && direct[1] <= most[1])
    return grid(direct[0], direct[1]);
  // m rectangles that a cell would own have about m + sqrt(m * density) places an axis, halved
  const double density = n * share[0] * share[1];
  const double root = (std::sqrt(density + 4 * kPlaces) - std::sqrt(density)) / 2;
  const double cells = n / (root * root), ratio = std::clamp(share[1] / share[0], 1 / 16., 16.);
  const double columns = std::min(std::ceil(std::sqrt(cells * ratio)), most[0]);
  const double strips = std::min(std::ceil(cells / columns), most[1]);
  return grid(std::min(std::ceil(cells / strips), most[0]), strips);
}

/// The rectangles that touch each strip.
class Strips {
 public:
  Strips(std::span<const OrdinalRectangle> all, const Cuts& cuts) : first_(cuts.parts() + 1) {
    constexpr std::size_t kChunk = 1 << 16, kMostChunks = 16;
    const std::size_t strips = cuts.parts(),
                      chunks = std::clamp(all.size() / kChunk, std::size_t{1}, kMostChunks);
    std::vector<std::size_t> places(chunks * strips);  // of a chunk's next rectangle in a strip
    const auto each = [&](auto&& f) {
      parallel_ranges(0, chunks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t chunk = begin; chunk < end; ++chunk) {
          std::size_t* const place = places.data() + chunk * strips;
          const std::size_t last = all.size() * (chunk + 1) / chunks;
          for (std::size_t i = all.size() * chunk / chunks; i < last; ++i) {
            const std::uint32_t to = cuts.part(all[i].hi[1]);
            for (std::uint32_t strip = cuts.part(all[i].lo[1]); strip <= to; ++strip) f(all[i], place[strip]);
          }
        }
      });
    };
    each([](const OrdinalRectangle&, std::size_t& count) { ++count; });
    std::size_t sum = 0;
    for (std::size_t strip = 0; strip < strips; ++strip) {
      first_[strip] = sum;
      for (std::size_t chunk = 0; chunk < chunks; ++chunk)
        sum += std::exchange(places[chunk * strips + strip], sum);
    }
    first_[strips] = sum;
    with_memory("the rectangles by strips", sum * sizeof(OrdinalRectangle), [&] { rectangles_.resize(sum); });
    each([this](const OrdinalRectangle& r, std::size_t& place) { rectangles_[place++] = r; });
  }

  std::size_t size() const { return first_.size() - 1; }
  std::span<const OrdinalRectangle> operator[](std::size_t strip) const {
    return std::span(rectangles_).subspan(first_[strip], first_[strip + 1] - first_[strip]);
  }

 private:
  std::vector<std::size_t> first_;
  Array<OrdinalRectangle> rectangles_;
};

/// Finds the vertices of one strip after the other.
class StripContour {
 public:
  explicit StripContour(const Cuts& columns) : columns_(columns), first_(columns.parts() + 1) {}

  /// The vertices of the strip of rows [lo, hi) that these rectangles touch, sorted.
  Array<ContourVertex> find(std::span<const OrdinalRectangle> strip, std::uint32_t lo, std::uint32_t hi) {
    bin(strip, lo, hi);
    vertices_.clear();
    for (std::uint32_t column = 0; column < columns_.parts(); ++column) {
      const std::size_t begin = first_[column], end = first_[column + 1];
      if (begin == end || covered_[column]) continue;
      cell_.find({{columns_.begin(column), lo}, {columns_.begin(column + 1), hi}},
                 std::span(binned_).subspan(begin, end - begin), vertices_);
    }
    return sorted(lo, hi);
  }

 private:
  /// Puts rectangles into the columns that they touch, and marks the columns that one of them covers.
  void bin(std::span<const OrdinalRectangle> strip, std::uint32_t lo, std::uint32_t hi) {
    covered_.assign(columns_.parts(), 0);
    std::ranges::fill(first_, 0);
    const auto each = [&](auto&& f) {
      for (const OrdinalRectangle& r : strip) {
        const std::uint32_t from = columns_.part(r.lo[0]), to = columns_.part(r.hi[0]);
        for (std::uint32_t column = from; column <= to; ++column) f(r, column);
      }
    };
    each([&](const OrdinalRectangle&, std::uint32_t column) { ++first_[column]; });
    for (const OrdinalRectangle& r : strip)
      if (r.lo[1] < lo && r.hi[1] >= hi)
        for (std::uint32_t column = columns_.part(r.lo[0]) + 1; column < columns_.part(r.hi[0]); ++column)
          covered_[column] = 1;
    std::inclusive_scan(first_.begin(), first_.end(), first_.begin());
    binned_.resize(first_.back());
    each([&](const OrdinalRectangle& r, std::uint32_t column) { binned_[--first_[column]] = r; });
  }

  /// Sorts by rows, or by some rows at once where there are more than vertices. Those of one row are sorted
  /// already.
  Array<ContourVertex> sorted(std::uint32_t lo, std::uint32_t hi) {
    const int shift = std::max(0, int(std::bit_width(hi - lo)) - int(std::bit_width(vertices_.size())));
    const auto bucket = [&](const ContourVertex& v) { return (v.y - lo) >> shift; };
    place_.assign((std::size_t{hi - lo} >> shift) + 2, 0);
    for (const ContourVertex& v : vertices_) ++place_[bucket(v) + 1];
    std::inclusive_scan(place_.begin(), place_.end(), place_.begin());
    Array<ContourVertex> result(vertices_.size());
    for (const ContourVertex& v : vertices_) result[place_[bucket(v)]++] = v;
    if (shift == 0) return result;
    for (std::size_t begin = 0, b = 0; begin < result.size(); begin = place_[b++])
      sort_bucket(std::span(result).subspan(begin, place_[b] - begin));
    return result;
  }

  static void sort_bucket(std::span<ContourVertex> bucket) {
    constexpr std::size_t kFew = 16;  // to be inserted one by one
    const auto before = [](const ContourVertex& v, const ContourVertex& w) {
      return v.y != w.y ? v.y < w.y : v.x < w.x;
    };
    if (bucket.size() > kFew) return std::sort(bucket.begin(), bucket.end(), before);
    for (std::size_t i = 1; i < bucket.size(); ++i) {
      const ContourVertex vertex = bucket[i];
      std::size_t j = i;
      for (; j > 0 && before(vertex, bucket[j - 1]); --j) bucket[j] = bucket[j - 1];
      bucket[j] = vertex;
    }
  }

  Cuts columns_;
  ContourCell cell_;
  std::vector<std::size_t> first_;  // of a column in binned_
  std::vector<std::uint8_t> covered_;
  Array<OrdinalRectangle> binned_;
  Array<ContourVertex> vertices_;
  std::vector<std::size_t> place_;  // of the next vertex of a bucket of rows
};

/// The vertices of each strip.
std::vector<Array<ContourVertex>> find_parts(Array<OrdinalRectangle> all, const PlaneAxes& axes) {
  constexpr std::size_t kGrain = 1 << 13;  // rectangles for a thread
  const Grid grid = make_grid(all, axes);
  const Strips strips(all, grid.strips);
  const std::size_t grain = std::max(kGrain * strips.size() / all.size(), std::size_t{1});
  all = Array<OrdinalRectangle>();  // {} would keep the memory
  PerThread<StripContour> finders(StripContour(grid.columns));
  std::vector<Array<ContourVertex>> parts(strips.size());
  parallel_ranges(0, strips.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Interruptible::check();
      const auto strip = static_cast<std::uint32_t>(i);
      parts[i] = finders.local().find(strips[i], grid.strips.begin(strip), grid.strips.begin(strip + 1));
    }
  });
  return parts;
}

Array<ContourVertex> joined(const std::vector<Array<ContourVertex>>& parts) {
  std::vector<std::size_t> first(parts.size() + 1);
  for (std::size_t i = 0; i < parts.size(); ++i) first[i + 1] = first[i] + parts[i].size();
  Array<ContourVertex> all;
  with_memory("the contour", first.back() * sizeof(ContourVertex), [&] { all.resize(first.back()); });
  parallel_ranges(0, parts.size(), parts.size() / 64 + 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
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

// As the lower plane of a solid, at z = 0, where only the area and the edges of that plane count; ordinal 0
// is there, too, because sums on lattices count from it.
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

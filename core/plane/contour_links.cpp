#include "core/plane/contour_links.hpp"

#include <array>

#include "core/base/parallel.hpp"
#include "core/boundary/planes.hpp"

namespace boxunion {
namespace {

/// Where the edges of a single corner lead, by the filled quadrants.
struct Turn {
  std::int8_t step = 0;     // to the next corner on the row, if it comes next on the loop
  bool to_below = false;    // the lower corner in the column comes next
  bool from_below = false;  // the lower corner in the column comes before
  bool begins = false;      // an edge goes right and one goes up
};

constexpr bool fills(std::uint32_t quadrants, Quadrant quadrant) {
  return quadrants >> quadrant & 1u;
}

constexpr auto kTurns = [] {
  std::array<Turn, 16> turns{};
  for (std::uint32_t q = 0; q < 16; ++q) {
    const bool lb = fills(q, left_below), rb = fills(q, right_below), la = fills(q, left_above),
               ra = fills(q, right_above);
    turns[q] = {static_cast<std::int8_t>((ra && !rb) - (lb && !la)), rb && !lb, lb && !rb,
                ra != rb && ra != la};
  }
  return turns;
}();

constexpr std::uint32_t kFalling = 1u << right_below | 1u << left_above;

}  // namespace

ContourColumns::ContourColumns(const Contour& contour)
    : vertices_(contour.vertices), count_(contour.axes[0].count() + 1) {
  constexpr std::size_t kFew = 1 << 16;
  if (count_ <= std::max(kFew, vertices_.size())) return;
  ranks_.assign(vertices_.size(), [this](std::size_t i) { return vertices_[i].x; });
  count_ = ranks_.distinct();
}

ContourLinks::ContourLinks(const Contour& contour, const ContourColumns& columns)
    : vertices_(contour.vertices) {
  constexpr std::size_t kFewest = 1 << 13;  // vertices of a band
  const std::size_t n = vertices_.size(), most = n / std::max(kFewest, std::size_t{columns.count()} / 4) + 1,
                    count = std::min(most, thread_count());
  // there are few upper corners, and unused elements take no memory
  with_memory("the loops", 2 * n * sizeof(std::uint32_t), [&] { next_.resize(2 * n); });
  for (std::size_t i = 1, begin = 0; i <= count; ++i) {
    std::size_t end = std::max(begin, n * i / count);
    while (end < n && end > 0 && vertices_[end].y == vertices_[end - 1].y) ++end;
    bands_.push_back({static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end), {}, {}});
    begin = end;
  }
  std::vector<std::vector<Dangling>> dangling(count);
  parallel_for_each(0, count, 1, [&](std::size_t i) { link(bands_[i], columns, dangling[i]); });
  for (std::size_t i = 1; i < count; ++i) join(bands_[i - 1], bands_[i], dangling[i]);
}

bool ContourLinks::touches(std::uint32_t corner) const {
  const std::uint32_t quadrants = vertices_[vertex(corner)].quadrants;
  return quadrants == kRising || quadrants == kFalling;
}

// Branch-free on the quadrants of a single corner, because the branch would be unpredictable.
void ContourLinks::link(Band& band, const ContourColumns& column_of, std::vector<Dangling>& dangling) {
  const auto n = static_cast<std::uint32_t>(vertices_.size());
  with_memory("the loops", column_of.count() * sizeof(std::uint32_t),
              [&] { band.last.resize(column_of.count()); });
  if (bands_.size() > 1) std::ranges::fill(band.last, kNone);
  with_memory("the loops", (band.end - band.begin) * sizeof(std::uint32_t),
              [&] { band.beginnings.resize(band.end - band.begin); });
  std::uint32_t* beginning = band.beginnings.data();
  std::uint32_t* const next = next_.data();
  for (std::uint32_t i = band.begin; i < band.end; ++i) {
    const std::uint32_t column = column_of[i], quadrants = vertices_[i].quadrants;
    const Turn turn = kTurns[quadrants];
    std::uint32_t& last = band.last[column];
    std::uint32_t below = last;
    last = i;
    if (band.begin > 0 && (turn.from_below || turn.to_below) && below == kNone) {
      dangling.push_back({column, i});
      below = i;
    }
    if (quadrants == kRising) {
      next[below] = i;
      next[i] = i - 1;
      next[n + i] = i + 1;
      last = *beginning++ = n + i;
    } else if (quadrants == kFalling) {
      next[i] = below;
      next[vertices_[i - 1].quadrants == kRising ? n + i - 1 : i - 1] = n + i;
      last = n + i;
    } else {
      next[turn.from_below ? below : i] = i;
      next[i] = turn.to_below ? below : i + static_cast<std::uint32_t>(turn.step);
      *beginning = i;
      beginning += turn.begins;
    }
  }
  band.beginnings.resize(static_cast<std::size_t>(beginning - band.beginnings.data()));
}

void ContourLinks::join(const Band& lower, Band& upper, std::span<const Dangling> dangling) {
  for (const auto [column, vertex] : dangling)
    if (kTurns[vertices_[vertex].quadrants].to_below)
      next_[vertex] = lower.last[column];
    else
      next_[lower.last[column]] = vertex;
  for (std::size_t column = 0; column < upper.last.size(); ++column)
    if (upper.last[column] == kNone) upper.last[column] = lower.last[column];
}

}  // namespace boxunion

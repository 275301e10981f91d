#include <fmt/format.h>

#include <algorithm>

#include "boxunion/error.hpp"
#include "boxunion/octants.hpp"
#include "core/base/interruptible.hpp"
#include "core/base/radix_sort.hpp"
#include "core/models/sections.hpp"
#include "core/slices/xor_merge.hpp"

namespace boxunion {
namespace {

/// Appends the vertices of a plane at the ordinal `ordinal`.
template <std::size_t D>
void append_plane(std::uint32_t ordinal, const ExtremeVertices<D>& plane, ExtremeVertices<D + 1>& vertices) {
  for (const OrderedPoint<D>& p : plane) {
    OrderedPoint<D + 1> vertex{ordinal};
    std::copy(p.begin(), p.end(), vertex.begin() + 1);
    vertices.push_back(vertex);
  }
}

/// The operation in D dimensions, section by section. The differences of the sections are the planes of the
/// result.
template <std::size_t D>
class Combination {
 public:
  explicit Combination(BooleanOperation operation) : operation_(operation), sections_(operation) {}

  void operator()(const ExtremeVertices<D>& p, const ExtremeVertices<D>& q, ExtremeVertices<D>& result) {
    result.clear();
    section_.clear();
    SectionSweep<D> sweep_p{std::span(p)}, sweep_q{std::span(q)};
    for (;;) {
      const std::uint32_t at = std::min(sweep_p.next(), sweep_q.next());
      if (at == Axis::kOrdinalMax) break;
      if (sweep_p.next() == at) sweep_p.advance();
      if (sweep_q.next() == at) sweep_q.advance();
      Interruptible::check();
      sections_(sweep_p.section(), sweep_q.section(), next_);
      exclusive_or(section_, next_, plane_);
      append_plane(at, plane_, result);
      std::swap(section_, next_);
    }
  }

 private:
  BooleanOperation operation_;
  Combination<D - 1> sections_;
  ExtremeVertices<D - 1> section_, next_, plane_;  // of the result
};

/// The operation on a line: the result has an end of an interval wherever its value changes.
template <>
class Combination<1> {
 public:
  explicit Combination(BooleanOperation operation) : table_(static_cast<unsigned>(operation)) {}

  void operator()(const ExtremeVertices<1>& p, const ExtremeVertices<1>& q,
                  ExtremeVertices<1>& result) const {
    result.clear();
    unsigned inside = 0;  // p + 2q
    for (std::size_t i = 0, j = 0; i < p.size() || j < q.size();) {
      const std::uint32_t at =
          std::min(i < p.size() ? p[i][0] : Axis::kOrdinalMax, j < q.size() ? q[j][0] : Axis::kOrdinalMax);
      const unsigned before = table_ >> inside & 1;
      if (i < p.size() && p[i][0] == at) ++i, inside ^= 1;
      if (j < q.size() && q[j][0] == at) ++j, inside ^= 2;
      if ((table_ >> inside & 1) != before) result.push_back({at});
    }
  }

 private:
  unsigned table_;
};

/// Appends the contour vertices on line y. `below` and `above` are the ends of the intervals below and above
/// it.
void append_contour(const ExtremeVertices<1>& below, const ExtremeVertices<1>& above, std::uint32_t y,
                    std::vector<ContourVertex>& contour) {
  unsigned before = 0;  // quadrants x = 0: below + 4 * above
  for (std::size_t i = 0, j = 0; i < below.size() || j < above.size();) {
    const std::uint32_t x = std::min(i < below.size() ? below[i][0] : Axis::kOrdinalMax,
                                     j < above.size() ? above[j][0] : Axis::kOrdinalMax);
    unsigned after = before;
    if (i < below.size() && below[i][0] == x) ++i, after ^= 1;
    if (j < above.size() && above[j][0] == x) ++j, after ^= 4;
    const bool varies_along_y = (before & 1) != before >> 2 || (after & 1) != after >> 2;
    if (varies_along_y) contour.push_back({x, y, before | after << 1});
    before = after;
  }
}

/// The contour of a section along z, in the order y, x.
void make_contour(const ExtremeVertices<2>& section, std::vector<ContourVertex>& contour) {
  contour.clear();
  ExtremeVertices<1> below;
  for (SectionSweep<2> lines{std::span(section)}; lines.next() != Axis::kOrdinalMax;) {
    const std::uint32_t y = lines.next();
    below = lines.section();
    lines.advance();
    append_contour(below, lines.section(), y, contour);
  }
}

}  // namespace

void validate(const AxisOrder& order) {
  if (!std::ranges::is_permutation(order, kAxisOrders[0]))
    throw Error(ErrorKind::usage,
                fmt::format("the order of the axes is {}, {}, {}, expected 0, 1 and 2 in any order", order[0],
                            order[1], order[2]));
}

std::string to_string(const AxisOrder& order) {
  validate(order);
  std::string name;
  for (const std::uint8_t axis : order) name += char('x' + axis);
  return name;
}

std::optional<AxisOrder> axis_order(std::string_view name) {
  const auto found = std::find_if(kAxisOrders.begin(), kAxisOrders.end(),
                                  [&](const AxisOrder& order) { return to_string(order) == name; });
  if (found == kAxisOrders.end()) return std::nullopt;
  return *found;
}

Evm make_evm(const Solid& solid, const AxisOrder& order) {
  validate(order);
  constexpr AxisOrder kSolidOrder = {2, 1, 0};
  const auto extreme = [](const Vertex& v) { return kOctants[v.mask].extreme; };
  Evm evm{solid.axes, order, {}};
  const auto count = std::size_t(std::count_if(solid.vertices.begin(), solid.vertices.end(), extreme));
  with_memory("the extreme vertices", count * sizeof(OrderedPoint<3>), [&] { evm.vertices.reserve(count); });
  interruptible_loop(solid.vertices.size(), [&](std::size_t i) {
    const Vertex& v = solid.vertices[i];
    const std::uint32_t p[] = {v.x, v.y, v.z};
    if (extreme(v)) evm.vertices.push_back({p[order[0]], p[order[1]], p[order[2]]});
  });
  if (order != kSolidOrder) radix_sort(std::span(evm.vertices), PointKey());
  return evm;
}

Evm reorder(const Evm& evm, const AxisOrder& order) {
  validate(evm.order);
  validate(order);
  Evm result = evm;
  if (order == evm.order) return result;
  result.order = order;
  std::array<std::size_t, 3> from{};  // position of each new axis in the old order
  for (std::size_t i = 0; i < 3; ++i)
    from[i] = std::size_t(std::find(evm.order.begin(), evm.order.end(), order[i]) - evm.order.begin());
  for (OrderedPoint<3>& p : result.vertices) p = {p[from[0]], p[from[1]], p[from[2]]};
  radix_sort(std::span(result.vertices), PointKey());
  return result;
}

template <std::size_t D, class C>
void exclusive_or(const std::vector<std::array<C, D>>& p, const std::vector<std::array<C, D>>& q,
                  std::vector<std::array<C, D>>& result) {
  if (p.empty() || q.empty()) {
    result = p.empty() ? q : p;
    return;
  }
  result.resize(p.size() + q.size());
  const OrderedPoint<D, C>*i = p.data(), *const p_end = i + p.size(),
                        *j = q.data(), *const q_end = j + q.size();
  OrderedPoint<D, C>* out = result.data();
  while (i != p_end && j != q_end) {
    const auto i_key = PointKey()(*i), j_key = PointKey()(*j);
    *out = j_key < i_key ? *j : *i;
    out += i_key != j_key;
    i += i_key <= j_key;
    j += j_key <= i_key;
  }
  out = std::copy(i, p_end, out);
  out = std::copy(j, q_end, out);
  result.resize(std::size_t(out - result.data()));
}
template void exclusive_or(const ExtremeVertices<1>&, const ExtremeVertices<1>&, ExtremeVertices<1>&);
template void exclusive_or(const ExtremeVertices<2>&, const ExtremeVertices<2>&, ExtremeVertices<2>&);
template void exclusive_or(const ExtremeVertices<3>&, const ExtremeVertices<3>&, ExtremeVertices<3>&);
template void exclusive_or(const ExtremeVertices<1, std::uint64_t>&, const ExtremeVertices<1, std::uint64_t>&,
                           ExtremeVertices<1, std::uint64_t>&);
template void exclusive_or(const ExtremeVertices<2, std::uint64_t>&, const ExtremeVertices<2, std::uint64_t>&,
                           ExtremeVertices<2, std::uint64_t>&);

template <std::size_t D, class C>
void SectionSweep<D, C>::advance() {
  const C at = next();
  plane_.clear();
  std::size_t count = 0;
  for (; count < rest_.size() && rest_[count][0] == at; ++count) {
    OrderedPoint<D - 1, C> projected;
    std::copy(rest_[count].begin() + 1, rest_[count].end(), projected.begin());
    plane_.push_back(projected);
  }
  rest_ = rest_.subspan(count);
  exclusive_or(section_, plane_, scratch_);
  std::swap(section_, scratch_);
}
template class SectionSweep<2>;
template class SectionSweep<3>;
template class SectionSweep<2, std::uint64_t>;

Evm combine(const Evm& p, const Evm& q, BooleanOperation operation) {
  validate(p.order);
  if (p.order != q.order)
    throw Error(ErrorKind::usage,
                fmt::format("one operand is sorted by {}, the other by {}, expected one order",
                            to_string(p.order), to_string(q.order)));
  if (p.axes != q.axes) throw Error(ErrorKind::usage, "the operands have different axes, expected the same");
  Evm result{p.axes, p.order, {}};
  Combination<3> combination(operation);
  combination(p.vertices, q.vertices, result.vertices);
  return result;
}

Solid make_solid(const Evm& evm) {
  Evm zyx = reorder(evm, {2, 1, 0});
  std::vector<std::uint32_t> distinct;  // distinct x; their positions are small enough for bitmaps
  for (const OrderedPoint<3>& p : zyx.vertices) distinct.push_back(p[2]);
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  for (OrderedPoint<3>& p : zyx.vertices)
    p[2] = std::uint32_t(std::lower_bound(distinct.begin(), distinct.end(), p[2]) - distinct.begin());

  Solid solid{evm.axes, {}};
  XorMerge merge(std::uint32_t(distinct.size()));
  std::vector<ContourVertex> lower, upper;
  for (SectionSweep<3> planes{std::span(zyx.vertices)}; planes.next() != Axis::kOrdinalMax;) {
    Interruptible::check();
    const std::uint32_t z = planes.next();
    planes.advance();
    make_contour(planes.section(), upper);
    const auto first = std::ptrdiff_t(solid.vertices.size());
    merge(lower, upper, z, solid.vertices);
    std::sort(solid.vertices.begin() + first, solid.vertices.end());
    std::swap(lower, upper);
  }
  for (Vertex& v : solid.vertices) v.x = distinct[v.x];
  return solid;
}

}  // namespace boxunion

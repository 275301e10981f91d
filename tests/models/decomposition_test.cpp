// Extreme vertices, disjoint boxes, their neighbors and components, compared with definitions on the grid
// through all faces.

#include "boxunion/decomposition.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include "boxunion/components.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "core/models/sections.hpp"
#include "host/files/files.hpp"
#include "tests/support/generators.hpp"
#include "tests/support/reference.hpp"

namespace boxunion {

static bool operator<(const OrdinalBox& p, const OrdinalBox& q) {
  return std::tie(p.lo, p.hi) < std::tie(q.lo, q.hi);
}

namespace {

Solid solid_of(const BoxSet& boxes) {
  return unite(boxes, {.device = "native", .threads = 1});
}

/// The cells of the grid through all faces that are inside, in the order A, B, C.
class Grid {
 public:
  Grid(std::span<const OrdinalBox> boxes, const AxisOrder& order) {
    for (std::size_t i = 0; i < 3; ++i) lines_[i] = distinct_ordinals(boxes, order[i]);
    inside_.assign(cells(0) * cells(1) * cells(2), false);
    for (const OrdinalBox& box : boxes) {
      std::array<std::size_t, 3> from{}, to{};
      for (std::size_t i = 0; i < 3; ++i) {
        from[i] = position(i, box.lo[order[i]]);
        to[i] = position(i, box.hi[order[i]]);
      }
      for (std::size_t a = from[0]; a < to[0]; ++a)
        for (std::size_t b = from[1]; b < to[1]; ++b)
          for (std::size_t c = from[2]; c < to[2]; ++c) inside_[index(a, b, c)] = true;
    }
  }

  std::size_t cells(std::size_t i) const { return lines_[i].empty() ? 0 : lines_[i].size() - 1; }
  std::uint32_t line(std::size_t i, std::size_t k) const { return lines_[i][k]; }
  bool inside(std::size_t a, std::size_t b, std::size_t c) const {
    return a < cells(0) && b < cells(1) && c < cells(2) && inside_[index(a, b, c)];
  }

  /// The points with an odd number of inside cells around them.
  ExtremeVertices<3> extreme_vertices() const {
    ExtremeVertices<3> vertices;
    for (std::size_t a = 0; a <= cells(0); ++a)
      for (std::size_t b = 0; b <= cells(1); ++b)
        for (std::size_t c = 0; c <= cells(2); ++c) {
          int count = 0;
          for (const std::size_t i : {0, 1})
            for (const std::size_t j : {0, 1})
              for (const std::size_t k : {0, 1}) count += inside(a - i, b - j, c - k);
          if (count % 2 == 1) vertices.push_back({line(0, a), line(1, b), line(2, c)});
        }
    return vertices;
  }

  /// Cuts wherever the section changes along A, and within a slice wherever it changes along B.
  std::set<OrdinalBox> oudb() const {
    const auto section_changes = [&](std::size_t a) {
      for (std::size_t b = 0; b < cells(1); ++b)
        for (std::size_t c = 0; c < cells(2); ++c)
          if (inside(a, b, c) != inside(a - 1, b, c)) return true;
      return false;
    };
    const auto line_changes = [&](std::size_t a, std::size_t b) {
      for (std::size_t c = 0; c < cells(2); ++c)
        if (inside(a, b, c) != inside(a, b - 1, c)) return true;
      return false;
    };
    std::set<OrdinalBox> boxes;
    for (std::size_t a = 0, next_a; a < cells(0); a = next_a) {
      for (next_a = a + 1; next_a < cells(0) && !section_changes(next_a);) ++next_a;
      for (std::size_t b = 0, next_b; b < cells(1); b = next_b) {
        for (next_b = b + 1; next_b < cells(1) && !line_changes(a, next_b);) ++next_b;
        for (std::size_t c = 0, next_c; c < cells(2); c = next_c) {
          for (next_c = c + 1; next_c < cells(2) && inside(a, b, next_c) == inside(a, b, c);) ++next_c;
          if (inside(a, b, c))
            boxes.insert(OrdinalBox{{line(0, a), line(1, b), line(2, c)},
                                    {line(0, next_a), line(1, next_b), line(2, next_c)}});
        }
      }
    }
    return boxes;
  }

  /// The number of components of the inside cells.
  std::size_t components(Connectivity connectivity) const {
    std::set<std::array<std::size_t, 3>> rest;
    for (std::size_t a = 0; a < cells(0); ++a)
      for (std::size_t b = 0; b < cells(1); ++b)
        for (std::size_t c = 0; c < cells(2); ++c)
          if (inside(a, b, c)) rest.insert({a, b, c});
    std::size_t count = 0;
    while (!rest.empty()) {
      ++count;
      std::vector<std::array<std::size_t, 3>> stack = {*rest.begin()};
      rest.erase(rest.begin());
      while (!stack.empty()) {
        const auto cell = stack.back();
        stack.pop_back();
        for (std::size_t k = 0; k < 27; ++k) {
          const std::array<std::size_t, 3> step = {k % 3, k / 3 % 3, k / 9};
          const auto moves = std::count_if(step.begin(), step.end(), [](std::size_t s) { return s != 1; });
          if (moves == 0 || (connectivity == Connectivity::faces && moves > 1)) continue;
          const std::array next = {cell[0] + step[0] - 1, cell[1] + step[1] - 1, cell[2] + step[2] - 1};
          if (rest.erase(next) != 0) stack.push_back(next);
        }
      }
    }
    return count;
  }

 private:
  std::size_t index(std::size_t a, std::size_t b, std::size_t c) const {
    return (a * cells(1) + b) * cells(2) + c;
  }
  std::size_t position(std::size_t i, std::uint32_t ordinal) const {
    return std::size_t(std::lower_bound(lines_[i].begin(), lines_[i].end(), ordinal) - lines_[i].begin());
  }
  std::array<std::vector<std::uint32_t>, 3> lines_;
  std::vector<bool> inside_;
};

/// Merges adjacent boxes on `axis` that are equal on the other axes.
std::set<OrdinalBox> compacted(std::set<OrdinalBox> boxes, std::size_t axis) {
  for (bool changed = true; changed;) {
    changed = false;
    for (auto p = boxes.begin(); p != boxes.end() && !changed; ++p)
      for (auto q = boxes.begin(); q != boxes.end() && !changed; ++q) {
        OrdinalBox moved = *q;
        moved.lo[axis] = p->lo[axis];
        moved.hi[axis] = p->hi[axis];
        if (p->hi[axis] != q->lo[axis] || !(moved == *p)) continue;
        OrdinalBox merged = *p;
        merged.hi[axis] = q->hi[axis];
        boxes.erase(*p);
        boxes.erase(*q);
        boxes.insert(merged);
        changed = true;
        break;
      }
  }
  return boxes;
}

/// The number of axes on which boxes overlap, and whether they touch at all.
struct Contact {
  int overlaps = 0;
  bool touch = true;
  std::size_t touching_axis = 3;  // the first on which they do not overlap
  Contact(const OrdinalBox& p, const OrdinalBox& q) {
    for (std::size_t i = 3; i-- > 0;) {
      touch = touch && p.lo[i] <= q.hi[i] && q.lo[i] <= p.hi[i];
      const bool overlap = p.lo[i] < q.hi[i] && q.lo[i] < p.hi[i];
      overlaps += overlap;
      if (!overlap) touching_axis = i;
    }
  }
  bool neighbors(Connectivity connectivity) const {
    return touch && (connectivity == Connectivity::points || overlaps == 2);
  }
};

void check_neighbors(const Decomposition& decomposition, Connectivity connectivity) {
  const Adjacency adjacency = find_neighbors(decomposition, connectivity);
  const auto& boxes = decomposition.boxes;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    std::array<std::vector<std::uint32_t>, 2> backward, forward;
    for (std::uint32_t j = 0; j < boxes.size(); ++j) {
      if (j == i) continue;
      const Contact contact(boxes[i], boxes[j]);
      ASSERT_LT(contact.overlaps, 3) << "the boxes are not disjoint";
      if (!contact.neighbors(connectivity)) continue;
      const std::size_t axis = contact.touching_axis;
      ASSERT_LT(axis, 2u) << "boxes touch along C";
      (boxes[i].hi[axis] == boxes[j].lo[axis] ? forward : backward)[axis].push_back(j);
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto found_backward = adjacency.backward[axis][i], found_forward = adjacency.forward[axis][i];
      ASSERT_TRUE(std::equal(found_backward.begin(), found_backward.end(), backward[axis].begin(),
                             backward[axis].end()));
      ASSERT_TRUE(
          std::equal(found_forward.begin(), found_forward.end(), forward[axis].begin(), forward[axis].end()));
    }
  }
}

void check_components(const Decomposition& decomposition, Connectivity connectivity, const Grid& grid) {
  const Adjacency adjacency = find_neighbors(decomposition, connectivity);
  const Labels found = label_components(adjacency);
  const std::vector<Component> components = measure_components(decomposition, found);
  ASSERT_EQ(found.count, grid.components(connectivity));
  ASSERT_EQ(components.size(), found.count);
  std::uint32_t seen = 0;
  std::map<std::uint32_t, std::vector<Box>> by_label;
  const BoxSet boxes = to_boxes(decomposition);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::uint32_t label = found.labels[i];
    ASSERT_LE(label, seen + 1);  // consecutive, in the order of their first boxes
    seen = std::max(seen, label);
    by_label[label].push_back(boxes[i]);
    for (const NeighborLists& lists : adjacency.forward)
      for (const std::uint32_t other : lists[i]) ASSERT_EQ(found.labels[other], label);
  }
  ASSERT_EQ(seen, found.count);
  for (const auto& [label, part] : by_label) {
    const Component& properties = components[label - 1];
    const MassProperties expected = measure(BoxSet(part), {.device = "native", .threads = 1});
    ASSERT_EQ(properties.boxes, part.size());
    ASSERT_EQ(properties.volume, expected.volume);
    ASSERT_EQ(properties.bounds, expected.bounds);
  }
}

void check(const BoxSet& boxes, bool components = true) {
  const Solid solid = solid_of(boxes);
  const std::vector<OrdinalBox> ordinals = ordinal_boxes(boxes, solid.axes);
  for (const AxisOrder& order : kAxisOrders) {
    SCOPED_TRACE(to_string(order));
    const Grid grid(ordinals, order);
    const Evm evm = make_evm(solid, order);
    ASSERT_EQ(evm.vertices, grid.extreme_vertices());
    ASSERT_EQ(make_solid(evm).vertices, solid.vertices);
    ASSERT_EQ(reorder(evm, kAxisOrders[0]).vertices, make_evm(solid, kAxisOrders[0]).vertices);

    const std::set<OrdinalBox> expected_oudb = grid.oudb();
    const std::set<OrdinalBox> expected_cudb = compacted(compacted(expected_oudb, 1), 0);
    for (const BoxModel model : {BoxModel::oudb, BoxModel::cudb}) {
      const std::set<OrdinalBox>& expected = model == BoxModel::oudb ? expected_oudb : expected_cudb;
      const Decomposition found = decompose(evm, model);
      ASSERT_EQ(found.boxes, std::vector(expected.begin(), expected.end()));
      ASSERT_EQ(count_boxes(evm, model), expected.size());
      ASSERT_EQ(make_evm(found).vertices, evm.vertices);
      for (const Connectivity connectivity : {Connectivity::faces, Connectivity::points}) {
        check_neighbors(found, connectivity);
        if (components) check_components(found, connectivity, grid);
      }
    }
    ASSERT_LE(expected_cudb.size(), expected_oudb.size());
  }
}

TEST(Decomposition, OfEveryOccupancyOf2x2x2) {
  for (std::uint64_t occupancy = 0; occupancy < 256; ++occupancy) {
    SCOPED_TRACE(occupancy);
    check(BoxSet(unit_cubes(occupancy, 2, 2, 2)));
    if (HasFatalFailure()) return;
  }
}

TEST(Decomposition, OfEveryOccupancyOf2x2x3) {
  for (std::uint64_t occupancy = 0; occupancy < 4096; ++occupancy) {
    SCOPED_TRACE(occupancy);
    check(BoxSet(unit_cubes(occupancy, 2, 2, 3)), false);
    if (HasFatalFailure()) return;
  }
}

TEST(Decomposition, OfRandomGrids) {
  std::random_device device;
  const auto seed = device();
  std::mt19937_64 random(seed);
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " round " + std::to_string(round));
    const int n = 2 + int(random() % 4);
    const std::uint64_t percent = 10 + random() % 80;
    std::vector<IntegerBox> cubes;
    for (int z = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          if (random() % 100 < percent) cubes.push_back({x, y, z, x + 1, y + 1, z + 1});
    check(BoxSet(cubes));
    if (HasFatalFailure()) return;
  }
}

TEST(Decomposition, OfRandomBoxes) {
  rc::check("lattice", [] {
    check(BoxSet(*boxes_from(small_integer())));
    RC_ASSERT(!testing::Test::HasFailure());
  });
  rc::check("ranks", [] {
    check(BoxSet(*boxes_from(decimal())));
    RC_ASSERT(!testing::Test::HasFailure());
  });
}

/// Converts in both directions and every order, for more boxes than brute force can handle.
void round_trips(const BoxSet& boxes, bool with_oudb = true) {
  const Solid solid = solid_of(boxes);
  for (const AxisOrder& order : kAxisOrders) {
    SCOPED_TRACE(to_string(order));
    const Evm evm = make_evm(solid, order);
    ASSERT_EQ(make_solid(evm).vertices, solid.vertices);
    const Decomposition cudb = decompose(evm, BoxModel::cudb);
    ASSERT_TRUE(std::is_sorted(cudb.boxes.begin(), cudb.boxes.end()));
    ASSERT_EQ(make_evm(cudb).vertices, evm.vertices);
    ASSERT_EQ(solid_of(to_boxes(cudb)).vertices.size(), solid.vertices.size());
    if (!with_oudb) continue;
    const Decomposition oudb = decompose(evm, BoxModel::oudb);
    ASSERT_EQ(make_evm(oudb).vertices, evm.vertices);
    ASSERT_LE(cudb.boxes.size(), oudb.boxes.size());
  }
}

TEST(Decomposition, IsTheSameOnAnyNumberOfThreads) {
  for (const BoxSet& boxes :
       {BoxSet(collect(generate_cubes(20000, 90, 4000, 1))), BoxSet(collect(generate_checkerboard(40))),
        BoxSet(collect(generate_boxes(4000, 1, 800, 1000, 3)))}) {
    const Solid solid = solid_of(boxes);
    for (const AxisOrder& order : kAxisOrders) {
      const Evm evm = make_evm(solid, order);
      const auto on_threads = [&](int threads) {
        tbb::task_arena arena(threads);
        return arena.execute([&] { return decompose(evm, BoxModel::cudb).boxes; });
      };
      const std::vector<OrdinalBox> expected = on_threads(1);
      for (const int threads : {2, 7}) ASSERT_EQ(on_threads(threads), expected);
      ASSERT_EQ(count_boxes(evm, BoxModel::cudb), expected.size());
    }
  }
}

TEST(Decomposition, RoundTripsOfManyBoxes) {
  round_trips(BoxSet(collect(generate_cubes(2000, 60, 1000, 1))));
  round_trips(BoxSet(collect(generate_cubes(3000, 10, 60, 2))));
  round_trips(BoxSet(collect(generate_checkerboard(12))));
  round_trips(BoxSet(collect(generate_sponge(3))));
}

TEST(Decomposition, RoundTripsOfStandardCells) {
  const std::string path = BOXUNION_DATA "/sky130_hd_row.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path << "; see BOXUNION_DATA";
  round_trips(read_boxes(path));
}

constexpr std::array kOperations = {BooleanOperation::intersect, BooleanOperation::unite,
                                    BooleanOperation::subtract, BooleanOperation::exclude};

std::uint64_t apply(BooleanOperation operation, std::uint64_t p, std::uint64_t q) {
  switch (operation) {
    case BooleanOperation::intersect:
      return p & q;
    case BooleanOperation::unite:
      return p | q;
    case BooleanOperation::subtract:
      return p & ~q;
    case BooleanOperation::exclude:
      return p ^ q;
  }
  return 0;
}

TEST(Decomposition, RoundTripsOfVoxels) {
  const std::string scene = BOXUNION_DATA "/scene_store11.vox";
  [[maybe_unused]] const std::string scan = BOXUNION_DATA "/100_fiberform.tif";
  if (!std::filesystem::exists(scene)) GTEST_SKIP() << "there is no " << scene << "; see BOXUNION_DATA";
  round_trips(read_boxes(scene));
#ifdef BOXUNION_HAVE_TIFF
  round_trips(read_boxes(scan, nullptr, {.threshold = 90}));
#endif
}

TEST(EvmCombine, EveryPairOfOccupanciesOf2x2x2) {
  const Axes axes = make_axes(BoxSet(unit_cubes(255, 2, 2, 2)));
  std::vector<Evm> evms;
  for (std::uint64_t occupancy = 0; occupancy < 256; ++occupancy) {
    const BoxSet cubes(unit_cubes(occupancy, 2, 2, 2));
    evms.push_back(make_evm(Solid{axes, brute_force_vertices(ordinal_boxes(cubes, axes))}, {2, 1, 0}));
  }
  for (std::uint64_t p = 0; p < 256; ++p)
    for (std::uint64_t q = 0; q < 256; ++q)
      for (const BooleanOperation operation : kOperations)
        ASSERT_EQ(combine(evms[p], evms[q], operation).vertices, evms[apply(operation, p, q)].vertices)
            << p << ' ' << q;
}

TEST(EvmCombine, Identities) {
  const std::vector<IntegerBox> p_boxes = collect(generate_boxes(150, 1, 40, 120, 7)),
                                q_boxes = collect(generate_boxes(150, 1, 40, 120, 8));
  std::vector<IntegerBox> both = p_boxes;
  both.insert(both.end(), q_boxes.begin(), q_boxes.end());
  const Axes axes = make_axes(BoxSet(both));
  const auto evm_of = [&](const std::vector<IntegerBox>& boxes, const AxisOrder& order) {
    Array<Vertex> vertices = brute_force_vertices(ordinal_boxes(BoxSet(boxes), axes));
    return make_evm(Solid{axes, vertices}, order);
  };
  const auto volume = [](const Evm& evm) {
    return measure(to_boxes(decompose(evm, BoxModel::cudb)), {.device = "native", .threads = 1}).volume;
  };
  for (const AxisOrder& order : kAxisOrders) {
    const Evm p = evm_of(p_boxes, order), q = evm_of(q_boxes, order);
    const Evm either = combine(p, q, BooleanOperation::unite),
              common = combine(p, q, BooleanOperation::intersect),
              rest = combine(p, q, BooleanOperation::subtract),
              different = combine(p, q, BooleanOperation::exclude);
    EXPECT_EQ(either.vertices, evm_of(both, order).vertices);
    EXPECT_EQ(combine(either, common, BooleanOperation::subtract).vertices, different.vertices);
    EXPECT_EQ(combine(rest, common, BooleanOperation::unite).vertices, p.vertices);
    EXPECT_EQ(combine(different, q, BooleanOperation::exclude).vertices, p.vertices);
    ExtremeVertices<3> odd;
    exclusive_or(p.vertices, q.vertices, odd);
    EXPECT_EQ(odd, different.vertices);
    EXPECT_EQ(volume(p) + volume(q), volume(either) + volume(common));
    EXPECT_TRUE(combine(p, p, BooleanOperation::subtract).vertices.empty());
  }
}

TEST(Components, KnownValues) {
  const auto count = [](const BoxSet& boxes, Connectivity connectivity) {
    const Decomposition cudb = decompose(make_evm(solid_of(boxes), {2, 1, 0}), BoxModel::cudb);
    return label_components(find_neighbors(cudb, connectivity)).count;
  };
  const BoxSet checkerboard(collect(generate_checkerboard(20)));
  EXPECT_EQ(count(checkerboard, Connectivity::faces), 4000u);
  EXPECT_EQ(count(checkerboard, Connectivity::points), 1u);
  const std::string path = BOXUNION_DATA "/sky130_hd_row.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path << "; see BOXUNION_DATA";
  EXPECT_EQ(count(read_boxes(path), Connectivity::faces), 3432u);
}

}  // namespace
}  // namespace boxunion

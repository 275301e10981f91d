// Sections as rectangles, and joins of faces, compared with definitions. Their work is counted.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "core/base/disjoint_sets.hpp"
#include "core/models/box_sweep.hpp"
#include "core/models/face_join.hpp"
#include "core/models/section_rectangles.hpp"
#include "host/files/files.hpp"
#include "tests/command/command.hpp"
#include "tests/support/families.hpp"
#include "tests/support/sanitized.hpp"

namespace boxunion {
namespace {

TEST(SortedChunks, AreASortedVector) {
  std::mt19937_64 random(1);
  SortedChunks<int> chunks;
  std::vector<int> vector;
  const auto check = [&] {
    ASSERT_EQ(chunks.size(), vector.size());
    auto place = SortedChunks<int>::Place();
    for (const int value : vector) {
      ASSERT_FALSE(chunks.is_end(place));
      ASSERT_EQ(chunks[place], value);
      place = chunks.next(place);
    }
    ASSERT_TRUE(chunks.is_end(place));
  };
  for (int round = 0; round < 4000; ++round) {
    const int key = int(random() % 10000);
    const auto is_before = [&](int value) { return value < key; };
    const auto place = chunks.find(is_before);
    const auto in_vector = std::partition_point(vector.begin(), vector.end(), is_before);
    const auto near = chunks.find_from(chunks.find([&](int v) { return v < key - 50; }), is_before);
    ASSERT_TRUE(near.chunk == place.chunk && near.index == place.index);
    // sometimes more, sometimes fewer, up to several chunks at once
    const std::size_t large = random() % 16 == 0 ? 400 : 4;
    const std::size_t rest = std::size_t(vector.end() - in_vector);
    std::size_t count = std::min<std::size_t>(random() % (round / 500 % 2 ? 2 * large : large), rest);
    if (round % 1000 == 999) count = rest;
    const int end = count < rest ? in_vector[std::ptrdiff_t(count)] : 10000;
    std::vector<int> values(random() % large);
    for (int& value : values) value = key + int(random() % std::uint64_t(std::max(1, end - key)));
    std::sort(values.begin(), values.end());
    const auto behind = chunks.replace(place, count, values);
    const auto at = vector.insert(vector.erase(in_vector, in_vector + std::ptrdiff_t(count)), values.begin(),
                                  values.end());
    ASSERT_EQ(chunks.is_end(behind), at + std::ptrdiff_t(values.size()) == vector.end());
    if (!chunks.is_end(behind)) {
      ASSERT_EQ(chunks[behind], at[std::ptrdiff_t(values.size())]);
    }
    if (round % 100 == 0) {
      chunks.erase_if([](int value) { return value % 7 == 0; });
      std::erase_if(vector, [](int value) { return value % 7 == 0; });
    }
    check();
    if (HasFatalFailure()) return;
  }
  chunks.clear();
  vector.clear();
  check();
}

TEST(SectionCells, ReachWhatTheyTouch) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 2000; ++round) {
    const std::uint64_t side = round % 2 ? 12 : 1000, longest = round % 3 ? 4 : side;
    const auto cell = [&] {
      const auto b = std::uint32_t(random() % side), c = std::uint32_t(random() % side);
      return SectionCell<std::uint32_t>{b, c, std::uint32_t(b + 1 + random() % longest),
                                        std::uint32_t(c + 1 + random() % longest)};
    };
    std::vector<SectionCell<std::uint32_t>> cells(1 + random() % 30);
    std::generate(cells.begin(), cells.end(), cell);
    std::vector<SectionRectangle<std::uint32_t>> rectangles;
    for (int i = 0; i < 30; ++i) {
      const auto [b_lo, c_lo, b_hi, c_hi] = cell();
      rectangles.push_back({b_lo, c_lo, b_hi, c_hi, 0});
    }
    std::sort(rectangles.begin(), rectangles.end(), [](auto& p, auto& q) { return p.b_lo < q.b_lo; });
    if (round % 4 < 2)
      std::sort(cells.begin(), cells.end(), [](auto& p, auto& q) { return p.b_lo < q.b_lo; });
    CellGrid<std::uint32_t> grid;
    CellReach<std::uint32_t> reach;
    grid.assign(cells);
    reach.assign(cells);
    const auto touches = [&](const auto& r) {
      return std::any_of(cells.begin(), cells.end(), [&](const auto& cell) {
        return r.b_lo <= cell.b_hi && cell.b_lo <= r.b_hi && r.c_lo <= cell.c_hi && cell.c_lo <= r.c_hi;
      });
    };
    for (const auto& r : rectangles) ASSERT_TRUE(grid.may_touch(r) || !touches(r)) << "round " << round;
    std::reverse(rectangles.begin(), rectangles.end());
    for (const auto& r : rectangles) ASSERT_EQ(reach.touches(r), touches(r)) << "round " << round;
  }
}

/// A section as squares of a grid.
class Squares {
 public:
  using Rectangle = std::array<std::uint32_t, 4>;  // b_lo, c_lo, b_hi, c_hi

  explicit Squares(std::uint32_t side) : side_(side), inside_(side * side) {}

  /// Flips a region and adds its corners to a plane of vertices.
  void flip(const Rectangle& r, std::set<OrderedPoint<2>>& plane) {
    for (std::uint32_t b = r[0]; b < r[2]; ++b)
      for (std::uint32_t c = r[1]; c < r[3]; ++c) inside_[b * side_ + c] ^= 1;
    for (const std::uint32_t b : {r[0], r[2]})
      for (const std::uint32_t c : {r[1], r[3]})
        if (const OrderedPoint<2> point{b, c}; !plane.insert(point).second) plane.erase(point);
  }

  /// The intervals of all rows, with equal neighbors merged.
  std::set<Rectangle> rectangles() const {
    std::set<Rectangle> all;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> open, next;
    for (std::uint32_t b = 0; b <= side_; ++b, open = std::move(next)) {
      next.clear();
      for (std::uint32_t c = 0, end; b < side_ && c < side_; c = end) {
        for (end = c + 1; end < side_ && at(b, end) == at(b, c);) ++end;
        if (!at(b, c)) continue;
        const auto same = open.find({c, end});
        next[{c, end}] = same == open.end() ? b : same->second;
        if (same != open.end()) open.erase(same);
      }
      for (const auto& [interval, begin] : open) all.insert({begin, interval.first, b, interval.second});
    }
    return all;
  }

 private:
  bool at(std::uint32_t b, std::uint32_t c) const { return inside_[b * side_ + c] != 0; }
  std::uint32_t side_;
  std::vector<char> inside_;
};

/// The effect of a plane: the rectangles that begin and end there, each in order.
struct Change {
  std::vector<Squares::Rectangle> begun, ended;
  friend bool operator==(const Change&, const Change&) = default;
};

/// Passes planes that flip the regions of `regions(a)`, and compares all rectangles that begin and end with
/// the definition.
template <class C>
void check_planes(std::uint32_t side, std::uint32_t planes, std::size_t at_once,
                  const std::function<std::vector<Squares::Rectangle>(std::uint32_t)>& regions) {
  Squares squares(side);
  SectionRectangles<C> section;
  std::map<std::uint32_t, Change> expected, found;
  std::set<Squares::Rectangle> before, after;
  std::map<Squares::Rectangle, C> marks;
  C mark = 0;
  const auto plain = [](const SectionRectangle<C>& r) {
    return Squares::Rectangle{std::uint32_t(r.b_lo), std::uint32_t(r.c_lo), std::uint32_t(r.b_hi),
                              std::uint32_t(r.c_hi)};
  };
  const auto begin = [&](const SectionRectangle<C>& r, C a) {
    found[std::uint32_t(a)].begun.push_back(plain(r));
    return marks[plain(r)] = ++mark;
  };
  const auto end = [&](const SectionRectangle<C>& r, C a) {
    found[std::uint32_t(a)].ended.push_back(plain(r));
    ASSERT_EQ(r.mark, marks.at(plain(r)));
  };
  ExtremeVertices<3, C> vertices;
  for (std::uint32_t a = 0; a < planes; ++a) {
    std::set<OrderedPoint<2>> plane;
    for (const Squares::Rectangle& region : regions(a)) squares.flip(region, plane);
    for (const auto& [b, c] : plane) vertices.push_back({a, b, c});
    after = squares.rectangles();
    Change change;
    std::set_difference(after.begin(), after.end(), before.begin(), before.end(),
                        std::back_inserter(change.begun));
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(),
                        std::back_inserter(change.ended));
    if (change != Change()) expected[a] = change;
    before = std::move(after);
    if (vertices.size() < at_once && a + 1 < planes) continue;
    section.pass(vertices, begin, end);
    vertices.clear();
    std::vector<Squares::Rectangle> all;
    for (const SectionRectangle<C>& r : section.all()) all.push_back(plain(r));
    ASSERT_EQ(all, std::vector(before.begin(), before.end()));
  }
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [a, change] : expected) ASSERT_TRUE(found[a] == change) << "plane " << a;
}

template <class C>
void check_random_planes(std::mt19937_64& random) {
  const auto side = std::uint32_t(4 + random() % (random() % 4 == 0 ? 60 : 12));
  const std::uint64_t most = 1 + random() % 6, longest = 1 + random() % side;
  const auto region = [&] {
    Squares::Rectangle r{};
    for (const std::size_t i : {0u, 1u}) {
      r[i] = std::uint32_t(random() % side);
      r[i + 2] = std::uint32_t(std::min<std::uint64_t>(side, r[i] + 1 + random() % longest));
    }
    return r;
  };
  check_planes<C>(side, 60, random() % 2 ? 1 : 1 << 20, [&](std::uint32_t) {
    std::vector<Squares::Rectangle> regions(random() % most);
    std::generate(regions.begin(), regions.end(), region);
    return regions;
  });
}

TEST(SectionRectangles, BeginAndEndAsDefinedInRandomSections) {
  const auto seed = std::random_device()();
  std::mt19937_64 random(seed);
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " round " + std::to_string(round));
    round % 2 ? check_random_planes<std::uint32_t>(random) : check_random_planes<std::uint64_t>(random);
    if (HasFatalFailure()) return;
  }
}

TEST(SectionRectangles, BeginAndEndAsDefinedInLargeSections) {
  // thousands of rectangles, small or long, and planes that change some of them, so that batches are halved
  constexpr std::uint32_t kSide = 150;
  std::mt19937_64 random(1);
  for (int shape = 0; shape < 3; ++shape) {
    const auto region = [&]() -> Squares::Rectangle {
      const auto b = std::uint32_t(random() % (kSide - 2)), c = std::uint32_t(random() % (kSide - 2));
      switch (shape) {
        case 0:
          return {b, c, b + 1 + std::uint32_t(random() % 2), c + 1 + std::uint32_t(random() % 2)};
        case 1:
          return {b / 8, c, kSide - b / 9, c + 1};
        default:
          return random() % 2 ? Squares::Rectangle{b, c / 8, b + 1, kSide - c / 9}
                              : Squares::Rectangle{b, c, b + 1, c + 1};
      }
    };
    check_planes<std::uint32_t>(kSide, 500, 1 << 20, [&](std::uint32_t a) {
      std::vector<Squares::Rectangle> regions(a == 0 ? 4000 : a % 100 == 50 ? 300 : 1 + random() % 3);
      std::generate(regions.begin(), regions.end(), region);
      return regions;
    });
    if (HasFatalFailure()) return;
  }
}

// ---- families of boxes ----

/// A base with a jagged end, and fins across it.
BoxSet heat_sink(int n) {
  std::vector<IntegerBox> boxes;
  for (int i = 0; i < n; ++i) {
    boxes.push_back({-1 - i % 2, i, 0, 2 * n, i + 1, 1});
    boxes.push_back({2 * i, 0, 1, 2 * i + 1, n, 2});
  }
  return boxes;
}

Solid solid_of(const BoxSet& boxes) {
  return unite(boxes, {.device = "native"});
}

BoxSet jittered_plates(std::size_t size) {
  const auto is_it = [](const Family& family) { return family.name == std::string("jittered_plates"); };
  return std::find_if(families().begin(), families().end(), is_it)->make(size);
}

/// The work of a sweep for the CUDB, and the sizes of its input and output.
struct Work {
  std::uint64_t steps = 0, size = 0;
};
Work sweep_work(const Solid& solid, std::size_t boxes, const AxisOrder& order) {
  const Evm evm = make_evm(solid, order);
  Work work{0, boxes + solid.vertices.size()};
  CudbSweep<std::uint32_t> sweep;
  const auto add = [&](const auto&, const auto&) { ++work.size; };
  for_each_plane(std::span(evm.vertices),
                 [&](const ExtremeVertices<2>& plane, std::uint32_t a) { sweep.pass(plane, a, add); });
  sweep.finish(add);
  work.steps = sweep.steps();
  return work;
}

TEST(SectionRectangles, WorkIsProportionalToInputAndOutput) {
  // looking at the whole section for every plane would take hundreds of steps
  for (const Family& family : families()) {
    const BoxSet boxes = family.make(sanitized() ? 2000 : 16000);
    const Solid solid = solid_of(boxes);
    for (const AxisOrder& order : kAxisOrders) {
      const Work work = sweep_work(solid, boxes.size(), order);
      EXPECT_LT(double(work.steps), 100.0 * double(work.size)) << family.name << ' ' << to_string(order);
    }
  }
}

TEST(Decomposition, OfFamiliesIsTheSameInPartsAndComponentsWithoutLists) {
  for (const Family& family : families()) {
    const Solid solid = solid_of(family.make(1000));
    for (const AxisOrder& order : kAxisOrders) {
      SCOPED_TRACE(family.name + std::string(" ") + to_string(order));
      const Evm evm = make_evm(solid, order);
      const Decomposition cudb = decompose(evm, BoxModel::cudb);
      ASSERT_EQ(make_evm(cudb).vertices, evm.vertices);
      const std::uint64_t count = cudb.boxes.size();
      ASSERT_EQ(count_boxes(evm, BoxModel::cudb), count);
      for (const std::uint64_t most : {std::uint64_t{0}, count / 2, count - 1, count, count + 1})
        ASSERT_EQ(count_boxes(evm, BoxModel::cudb, most), std::min(count, most + 1));
      for (const Connectivity connectivity : {Connectivity::faces, Connectivity::points}) {
        const Labels expected = label_components(find_neighbors(cudb, connectivity)),
                     found = label_components(cudb, connectivity);
        ASSERT_EQ(found.count, expected.count);
        ASSERT_EQ(found.labels, expected.labels);
      }
    }
  }
}

TEST(Decomposition, CountsTheOudbUpToALimit) {
  const Evm evm = make_evm(solid_of(jittered_plates(50)), {0, 1, 2});
  const std::uint64_t count = decompose(evm, BoxModel::oudb).boxes.size();
  for (const std::uint64_t most : {std::uint64_t{0}, count / 2, count - 1, count, count + 1})
    ASSERT_EQ(count_boxes(evm, BoxModel::oudb, most), std::min(count, most + 1));
}

// ---- joins of faces ----

struct TestFace {
  std::uint32_t p_lo, p_hi, q_lo, q_hi, box;
};
using Faces = std::vector<TestFace>;

/// Joins faces sorted by p and q. `add` gets pairs of boxes. Returns the work.
template <FacePairs kPairs, class Add>
std::uint64_t join(const Faces& below, const Faces& above, bool touch_p, bool touch_q, Add&& add) {
  FaceJoin<TestFace, kPairs> join(touch_p, touch_q);
  std::set<std::uint32_t> begins;
  for (const Faces* faces : {&below, &above})
    for (const TestFace& f : *faces) begins.insert(f.p_lo);
  const auto begun = [](const Faces& faces, std::uint32_t p) {
    const auto first = std::partition_point(faces.begin(), faces.end(), [&](auto& f) { return f.p_lo < p; });
    return std::span(first, std::partition_point(first, faces.end(), [&](auto& f) { return f.p_lo == p; }));
  };
  for (const std::uint32_t p : begins)
    join.advance(begun(below, p), begun(above, p), [&](auto& f, auto& g) { add(f.box, g.box); });
  return join.steps();
}

/// Disjoint faces in a grid of `columns` columns on q, with random heights on p.
Faces random_faces(std::mt19937_64& random, std::uint32_t columns, std::uint32_t height, std::uint32_t box) {
  Faces faces;
  std::vector<std::uint32_t> free_from(columns);
  for (std::uint32_t p = 0; p < height; ++p)
    for (std::uint32_t q = 0; q < columns; ++q) {
      if (random() % 3 != 0) continue;
      std::uint32_t end = q;
      const auto wanted = std::uint32_t(q + 1 + random() % (random() % 4 == 0 ? columns : 3));
      while (end < columns && end < wanted && free_from[end] <= p) ++end;
      if (end == q) continue;
      const TestFace f{p, std::uint32_t(p + 1 + random() % (random() % 4 == 0 ? height : 3)), q, end, box++};
      for (std::uint32_t i = q; i < end; ++i) free_from[i] = f.p_hi;
      faces.push_back(f);
    }
  return faces;
}

TEST(FaceJoin, FindsAllPairsAndEnoughOfThem) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 2000; ++round) {
    const auto columns = std::uint32_t(1 + random() % 30), height = std::uint32_t(1 + random() % 30);
    const Faces below = random_faces(random, columns, height, 0);
    const Faces above = random_faces(random, columns, height, std::uint32_t(below.size()));
    const auto boxes = std::uint32_t(below.size() + above.size());
    for (const bool touch_p : {false, true})
      for (const bool touch_q : {false, true}) {
        std::set<std::pair<std::uint32_t, std::uint32_t>> expected, found;
        for (const TestFace& f : below)
          for (const TestFace& g : above)
            if ((touch_p ? f.p_lo <= g.p_hi && g.p_lo <= f.p_hi : f.p_lo < g.p_hi && g.p_lo < f.p_hi) &&
                (touch_q ? f.q_lo <= g.q_hi && g.q_lo <= f.q_hi : f.q_lo < g.q_hi && g.q_lo < f.q_hi))
              expected.insert({f.box, g.box});
        DisjointSets all(boxes, "a test"), enough(boxes, "a test");
        join<FacePairs::all>(below, above, touch_p, touch_q, [&](std::uint32_t f, std::uint32_t g) {
          ASSERT_TRUE(found.insert({f, g}).second);
          all.join(f, g);
        });
        ASSERT_EQ(found, expected) << "round " << round;
        join<FacePairs::enough>(below, above, touch_p, touch_q, [&](std::uint32_t f, std::uint32_t g) {
          ASSERT_TRUE(expected.contains({f, g}));
          enough.join(f, g);
        });
        for (std::uint32_t i = 0; i < boxes; ++i) ASSERT_EQ(all.find(i), enough.find(i)) << "round " << round;
      }
  }
}

TEST(FaceJoin, WorkIsProportionalToFacesAndPairs) {
  constexpr std::uint32_t kCount = 3000;
  const auto ignore = [](std::uint32_t, std::uint32_t) {};
  Faces narrow, wide, deep;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    narrow.push_back({0, 1, i, i + 1, i});
    deep.push_back({0, 10 + 2 * kCount, i, i + 1, i});
    wide.push_back({10 + 2 * i, 11 + 2 * i, 0, kCount, kCount + i});
  }
  // the sweep has left the narrow faces when it reaches the wide ones, which must not look at them repeatedly
  EXPECT_LT(join<FacePairs::all>(narrow, wide, false, false, ignore), 10 * kCount);
  EXPECT_LT(join<FacePairs::all>(wide, narrow, true, true, ignore), 10 * kCount);
  // nine million pairs
  EXPECT_GT(join<FacePairs::all>(deep, wide, false, false, ignore), std::uint64_t{kCount} * kCount);
  EXPECT_LT(join<FacePairs::enough>(deep, wide, false, false, ignore), 10 * kCount);
  EXPECT_LT(join<FacePairs::enough>(wide, deep, false, false, ignore), 10 * kCount);
}

// ---- interrupts ----

TEST(Decomposition, EndsSoonWhenInterrupted) {
  using Clock = std::chrono::steady_clock;
  const Solid plates = solid_of(jittered_plates(4000)), sink = solid_of(heat_sink(3000));
  const Evm evm = make_evm(plates, {0, 1, 2});
  const Decomposition cudb = decompose(make_evm(sink, {2, 1, 0}), BoxModel::cudb);
  const std::vector<std::function<void()>> works = {
      [&] { count_boxes(evm, BoxModel::oudb); },  // tens of billions
      [&] {
        for (;;) find_neighbors(cudb, Connectivity::faces);  // nine million pairs
      },
      [&] {
        for (;;) decompose(evm, BoxModel::cudb);
      },
      [&] {
        for (;;) label_components(cudb, Connectivity::points);
      }};
  for (const auto& work : works)
    for (const int milliseconds : {0, 30, 200}) {
      std::atomic<bool> flag = false;
      const Interruptible scope(&flag);
      Clock::time_point raised;
      std::thread timer([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
        raised = Clock::now();
        flag = true;
      });
      std::optional<ErrorKind> kind;
      try {
        work();
      } catch (const Error& error) {
        kind = error.kind();
      }
      timer.join();
      EXPECT_EQ(kind, ErrorKind::interrupted);
      EXPECT_LT(Clock::now() - raised, std::chrono::seconds(1));
    }
}

TEST_F(Command, TheBestOrderIsFoundWithoutCountingTheWorst) {
  write_boxes(jittered_plates(8000), open_output(folder_.file("a.npy")));
  for (const std::string options : {"", " --memory 512M"}) {
    const nlohmann::json result = json("decompose a.npy --json --model oudb --order best" + options);
    EXPECT_EQ(result.at("boxes"), 8000);  // along x and y there are hundreds of billions
    EXPECT_EQ(result.at("order"), "zxy");
  }
}

}  // namespace
}  // namespace boxunion

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/base/sorted_chunks.hpp"

namespace boxunion {

/// Which pairs of faces a FaceJoin gives.
enum class FacePairs {
  all,
  enough  ///< as many as connect the same faces: of n faces about n, where there may be n^2 pairs
};

/// Joins the faces of boxes that end in a plane with those of boxes that begin there, by a sweep along p. A
/// face is a rectangle [p_lo, p_hi] x [q_lo, q_hi]. Those of one side do not overlap each other, so those
/// that cross the line of the sweep are sorted by q. n faces and pairs take O(n log n) time.
template <class Face, FacePairs kPairs = FacePairs::all>
class FaceJoin {
 public:
  /// Whether faces that only touch on p, or on q, count as well.
  FaceJoin(bool touch_p, bool touch_q) : touch_p_(touch_p), touch_q_(touch_q) {}

  /// Begins a plane.
  void clear() {
    below_.clear();
    above_.clear();
  }

  /// Takes the faces of both sides that begin at the next p, sorted by q. Calls add(below, above) for their
  /// pairs with each other and with those before.
  template <class Add>
  void advance(std::span<const Face> below, std::span<const Face> above, Add&& add) {
    for (const Face& f : below) {
      const auto add_above = [&](const Face& other) { add(f, other); };
      for_each_overlap(f, above_, add_above);
      for_each_overlap(f, above, add_above);
    }
    for (const Face& f : above) for_each_overlap(f, below_, [&](const Face& other) { add(other, f); });
    below_.insert(below);
    above_.insert(above);
  }

  /// The work so far: how many faces it has looked at.
  std::uint64_t steps() const { return steps_; }

 private:
  class Line;

  /// Of faces that begin at f's low end of p, sorted by q.
  template <class Add>
  void for_each_overlap(const Face& f, std::span<const Face> begun, Add&& add) {
    Interruptible::check();
    ++steps_;
    const auto first = std::partition_point(begun.begin(), begun.end(),
                                            [&](const Face& other) { return is_before(other, f); });
    for (auto i = first; i != begun.end() && !is_behind(*i, f); ++i, ++steps_) add(*i);
  }

  /// Of `line`, which has faces that begin before. Those that the sweep has left are removed, so that they
  /// are in the way once.
  template <class Add>
  void for_each_overlap(const Face& f, Line& line, Add&& add) {
    Interruptible::check();
    ++steps_;
    bool is_first = true;
    auto i = line.faces.find([&](const Face& other) { return is_before(other, f); });
    while (!line.faces.is_end(i) && !is_behind(line.faces[i], f)) {
      ++steps_;
      const Face& other = line.faces[i];
      if (touch_p_ ? other.p_hi < f.p_lo : other.p_hi <= f.p_lo) {
        i = line.remove(i);
        continue;
      }
      add(other);
      i = line.next(i, !is_first);
      is_first = false;
    }
  }

  bool is_before(const Face& other, const Face& f) const {
    return touch_q_ ? other.q_hi < f.q_lo : other.q_hi <= f.q_lo;
  }
  bool is_behind(const Face& other, const Face& f) const {
    return touch_q_ ? other.q_lo > f.q_hi : other.q_lo >= f.q_hi;
  }

  bool touch_p_, touch_q_;
  Line below_, above_;
  std::uint64_t steps_ = 0;
};

// ---- implementation ----

/// Faces that the sweep has reached, sorted by q. Those that it has left stay until they are in the way or
/// have become too many.
///
/// Where not all pairs are wanted, neighbors that are known to be connected make up a run, of which one is
/// as good as all. A run that a face reaches joins the run before it, so runs are passed once.
template <class Face, FacePairs kPairs>
class FaceJoin<Face, kPairs>::Line {
 public:
  using Place = typename SortedChunks<Face>::Place;

  SortedChunks<Face> faces;

  void clear() {
    faces.clear();
    heads_.clear();
  }

  /// Adds faces, sorted by q, in the place of those that lie there.
  void insert(std::span<const Face> begun) {
    Place place;
    for (const Face& f : begun) {
      place = faces.find_from(place, [&](const Face& old) { return old.q_hi <= f.q_lo; });
      if constexpr (kPairs == FacePairs::all) {
        std::size_t left = 0;
        for (Place i = place; !faces.is_end(i) && faces[i].q_lo < f.q_hi; i = faces.next(i)) ++left;
        place = faces.replace(place, left, {&f, 1});
        continue;
      }
      while (!faces.is_end(place) && faces[place].q_lo < f.q_hi) place = remove(place);
      place = faces.replace(place, 0, {&f, 1});
      add_head(f.q_lo);
      if (!faces.is_end(place)) add_head(faces[place].q_lo);
    }
    if (faces.size() <= limit_) return;
    faces.erase_if([p = begun[0].p_lo](const Face& old) { return old.p_hi <= p; });
    limit_ = 2 * faces.size() + 64;
    if constexpr (kPairs == FacePairs::all) return;
    std::vector<Q> all;
    for (Place i; !faces.is_end(i); i = faces.next(i)) all.push_back(faces[i].q_lo);
    heads_.clear();
    heads_.replace({}, 0, all);
  }

  /// Returns the place behind.
  Place remove(Place i) {
    const Q q = faces[i].q_lo;
    i = faces.replace(i, 1, {});
    if constexpr (kPairs == FacePairs::enough)
      if (remove_head(q) && !faces.is_end(i)) add_head(faces[i].q_lo);
    return i;
  }

  /// The next place to look at behind i, whose run joins the one before it, or not.
  Place next(Place i, bool joins) {
    if constexpr (kPairs == FacePairs::all) return faces.next(i);
    const Q q = faces[i].q_lo;
    if (joins) remove_head(q);
    const auto head = heads_.find([&](Q other) { return other <= q; });
    return faces.find([&](const Face& f) { return heads_.is_end(head) || f.q_lo < heads_[head]; });
  }

 private:
  using Q = decltype(Face::q_lo);

  void add_head(Q q) {
    const auto place = heads_.find([&](Q head) { return head < q; });
    if (heads_.is_end(place) || heads_[place] != q) heads_.replace(place, 0, {&q, 1});
  }
  bool remove_head(Q q) {
    const auto place = heads_.find([&](Q head) { return head < q; });
    if (heads_.is_end(place) || heads_[place] != q) return false;
    heads_.replace(place, 1, {});
    return true;
  }

  SortedChunks<Q> heads_;  // the low ends of the first faces of all runs
  std::size_t limit_ = 64;
};

}  // namespace boxunion

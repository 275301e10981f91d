#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/base/sorted_chunks.hpp"

namespace boxunion {

/// Which pairs of faces a FaceJoin reports.
enum class FacePairs {
  all,
  enough  ///< enough to connect the same faces: about n pairs for n faces, which may have n^2
};

/// Joins the faces of boxes that end in a plane with those of boxes that begin there, by a sweep along p. A
/// face is a rectangle [p_lo, p_hi] x [q_lo, q_hi]. Faces of one side do not overlap, so those on the line of
/// the sweep are sorted by q. Takes O(n log n) time for n faces and pairs.
template <class Face, FacePairs kPairs = FacePairs::all>
class FaceJoin {
 public:
  /// `touch_p`, `touch_q`: whether faces that only touch on p, or on q, make a pair.
  FaceJoin(bool touch_p, bool touch_q) : touch_p_(touch_p), touch_q_(touch_q) {}

  /// Begins a plane.
  void clear() {
    below_.clear();
    above_.clear();
  }

  /// Takes the faces of both sides that begin at the next p, sorted by q. Calls add(below, above) for each of
  /// their pairs, with each other and with earlier faces.
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

  /// The work so far: the number of faces looked at.
  std::uint64_t steps() const { return steps_; }

 private:
  class Line;

  /// Calls add for the faces of `begun`, sorted by q, that overlap f.
  template <class Add>
  void for_each_overlap(const Face& f, std::span<const Face> begun, Add&& add) {
    Interruptible::check();
    ++steps_;
    const auto first = std::partition_point(begun.begin(), begun.end(),
                                            [&](const Face& other) { return is_before(other, f); });
    for (auto i = first; i != begun.end() && !is_behind(*i, f); ++i, ++steps_) add(*i);
  }

  /// Calls add for the faces of `line`, which began earlier, that overlap f. Removes faces that the sweep has
  /// left, so that each is in the way only once.
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

/// The faces on the line of the sweep, sorted by q. Faces that the sweep has left stay until they are in the
/// way or there are too many.
///
/// For FacePairs::enough, neighbors that are known to be connected form a run, and one pair stands for the
/// whole run. A run that a new face touches is joined to the run before it, so each run is passed once.
template <class Face, FacePairs kPairs>
class FaceJoin<Face, kPairs>::Line {
 public:
  using Place = typename SortedChunks<Face>::Place;

  SortedChunks<Face> faces;

  void clear() {
    faces.clear();
    heads_.clear();
  }

  /// Adds faces, sorted by q, and removes the old ones that overlap them.
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

  /// Removes a face and returns the place behind it.
  Place remove(Place i) {
    const Q q = faces[i].q_lo;
    i = faces.replace(i, 1, {});
    if constexpr (kPairs == FacePairs::enough)
      if (remove_head(q) && !faces.is_end(i)) add_head(faces[i].q_lo);
    return i;
  }

  /// The next place to look at after i. If `joins`, the run of i is joined to the run before it.
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

  SortedChunks<Q> heads_;  // the low end of the first face of each run
  std::size_t limit_ = 64;
};

}  // namespace boxunion

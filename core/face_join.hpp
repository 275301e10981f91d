#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace boxunion {

/// Joins the faces of boxes that end in a plane with those of boxes that begin there, by a sweep along p. A
/// face is a rectangle [p_lo, p_hi] x [q_lo, q_hi]. Those of one side do not overlap each other, so those
/// that cross the line of the sweep are sorted by q.
template <class Face>
class FaceJoin {
 public:
  /// Whether faces that only touch on p, or on q, count as well.
  FaceJoin(bool touch_p, bool touch_q) : touch_p_(touch_p), touch_q_(touch_q) {}

  /// Begins a plane.
  void clear() {
    below_.faces.clear();
    above_.faces.clear();
  }

  /// Takes the faces of both sides that begin at the next p, sorted by q. Calls add(below, above) for their
  /// pairs with each other and with those before.
  template <class Add>
  void advance(std::span<const Face> below, std::span<const Face> above, Add&& add) {
    for (const Face& f : below) {
      const auto add_above = [&](const Face& other) { add(f, other); };
      for_each_overlap(f, above_.faces, add_above);
      for_each_overlap(f, above, add_above);
    }
    for (const Face& f : above) for_each_overlap(f, below_.faces, [&](const Face& other) { add(other, f); });
    below_.insert(below);
    above_.insert(above);
  }

 private:
  /// Faces that the sweep has reached, sorted by q. Those that it has left stay until others take their place
  /// or they have become too many.
  struct Line {
    std::vector<Face> faces;
    std::size_t limit = 64;

    void insert(std::span<const Face> begun) {
      for (const Face& f : begun) {
        const auto first = std::partition_point(faces.begin(), faces.end(),
                                                [&](const Face& old) { return old.q_hi <= f.q_lo; });
        auto last = first;
        while (last != faces.end() && last->q_lo < f.q_hi) ++last;
        if (first == last) {
          faces.insert(first, f);
        } else {
          *first = f;
          faces.erase(first + 1, last);
        }
      }
      if (faces.size() <= limit) return;
      std::erase_if(faces, [p = begun[0].p_lo](const Face& old) { return old.p_hi <= p; });
      limit = 2 * faces.size() + 64;
    }
  };

  /// Of `line`, which has faces that begin at f's low end of p or before.
  template <class Add>
  void for_each_overlap(const Face& f, std::span<const Face> line, Add&& add) const {
    const auto is_before = [&](const Face& other) {
      return touch_q_ ? other.q_hi < f.q_lo : other.q_hi <= f.q_lo;
    };
    for (auto i = std::partition_point(line.begin(), line.end(), is_before);
         i != line.end() && (touch_q_ ? i->q_lo <= f.q_hi : i->q_lo < f.q_hi); ++i)
      if (touch_p_ ? i->p_hi >= f.p_lo : i->p_hi > f.p_lo) add(*i);
  }

  bool touch_p_, touch_q_;
  Line below_, above_;
};

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "boxunion/box.hpp"
#include "core/boxes/ordinals.hpp"
#include "core/cells/tiles.hpp"
#include "core/solid/statistics.hpp"
#include "host/external/slab_files.hpp"
#include "host/files/box_file.hpp"

// The first pass over the boxes of a file.

namespace boxunion {

/// The findings of one pass over a file.
struct Survey {
  LatticeScan lattices;
  std::uint64_t degenerate = 0;
  std::vector<Box> sample;

  void join(const Survey& other) {
    lattices.join(other.lattices);
    degenerate += other.degenerate;
    sample.insert(sample.end(), other.sample.begin(), other.sample.end());
  }

  /// True if many boxes span a large part of the whole.
  bool are_long() const;
};

/// Reads all boxes of a file once, and adds them to `sums` if that is not null. Throws for the first invalid
/// box.
Survey survey_boxes(const BoxFile& file, BoxSummer* sums);

inline bool is_degenerate(const Box& box) {
  return box[0] == box[3] || box[1] == box[4] || box[2] == box[5];
}

/// The boxes of a file that are not degenerate.
template <class C>
class FileSource final : public BoxSource<C> {
 public:
  FileSource(const BoxFile& file, const Survey& survey, const Axes& axes)
      : file_(file), survey_(survey), axes_(axes) {}

  std::uint64_t size() const override { return file_.size(); }
  std::uint64_t count() const override { return file_.size() - survey_.degenerate; }
  void read(std::uint64_t begin, std::uint64_t end, std::vector<BoxOf<C>>& boxes) const override {
    const BoxSet all = file_.read(begin, end);
    boxes.clear();
    if constexpr (std::is_same_v<C, std::uint32_t>)
      OrdinalSource(all, axes_).read(0, all.size(), [&](const OrdinalBox& b) {
        boxes.push_back({b.lo[0], b.lo[1], b.lo[2], b.hi[0], b.hi[1], b.hi[2]});
      });
    else
      for (std::size_t i = 0; i < all.size(); ++i)
        if (const Box box = all[i]; !is_degenerate(box)) boxes.push_back(box);
  }
  std::vector<Box> sample() const override {
    std::vector<Box> sample = survey_.sample;
    if constexpr (std::is_same_v<C, std::uint32_t>)
      for (Box& box : sample)
        for (unsigned c = 0; c < 6; ++c) box[c] = double(axes_[c % 3].ordinal(box[c]));
    return sample;
  }

 private:
  const BoxFile& file_;
  const Survey& survey_;
  const Axes& axes_;
};

}  // namespace boxunion

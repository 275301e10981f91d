#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "boxunion/box.hpp"
#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"
#include "core/boxes/cuts.hpp"
#include "core/boxes/ordinals.hpp"
#include "host/files/scratch.hpp"

// Boxes on disk, cut into slabs. Their coordinates C are uint32 ordinals if all axes are lattices, and
// doubles otherwise. None is degenerate.

namespace boxunion {

/// A part of space. It owns the points lo <= p < hi.
template <class C>
struct RegionOf {
  std::array<C, 3> lo, hi;
};

/// The coordinate that stands for everything below a region: the next one below it.
inline std::uint32_t just_below(std::uint32_t lo) {
  return lo - 1;
}
inline double just_below(double lo) {
  return std::nextafter(lo, -std::numeric_limits<double>::infinity());
}

/// Boxes that can be read in pieces.
template <class C>
class BoxSource {
 public:
  virtual ~BoxSource() = default;
  virtual std::uint64_t size() const = 0;
  /// The number of boxes that read() gives, without degenerate ones.
  virtual std::uint64_t count() const { return size(); }
  /// Replaces `boxes` by boxes begin .. end - 1, in any order. Thread-safe.
  virtual void read(std::uint64_t begin, std::uint64_t end, std::vector<BoxOf<C>>& boxes) const = 0;
  /// A sample of the boxes, as doubles.
  virtual std::vector<Box> sample() const;

  static constexpr std::uint64_t kPiece = 1 << 16;   ///< boxes read at once
  static constexpr std::uint64_t kSample = 1 << 16;  ///< boxes of a sample
  /// Calls f(boxes) for all boxes, piece by piece, on several threads.
  template <class F>
  void each_piece(F&& f) const;
};

/// The boxes that touch a region, clipped to what the region sees of them: from just below it to its end. In
/// a region of fewer than 2^16 ordinals, an ordinal takes two bytes.
template <class C>
class SlabFile final : public BoxSource<C> {
 public:
  SlabFile(const RegionOf<C>& region, ScratchFile file) : region_(region), file_(std::move(file)) {
    if constexpr (std::is_same_v<C, std::uint32_t>) {
      is_narrow_ = true;
      for (unsigned a = 0; a < 3; ++a) {
        base_[a] = region.lo[a] == 0 ? 0 : just_below(region.lo[a]);
        is_narrow_ &= region.hi[a] - base_[a] <= std::numeric_limits<std::uint16_t>::max();
      }
    }
  }

  const RegionOf<C>& region() const { return region_; }
  std::uint64_t size() const override { return file_.size() / bytes_a_box(); }
  void append(std::span<const BoxOf<C>> boxes);
  void read(std::uint64_t begin, std::uint64_t end, std::vector<BoxOf<C>>& boxes) const override;

 private:
  using Narrow = BoxOf<std::uint16_t>;
  std::uint64_t bytes_a_box() const { return is_narrow_ ? sizeof(Narrow) : sizeof(BoxOf<C>); }

  RegionOf<C> region_;
  std::array<C, 3> base_{};  // origin of narrow ordinals
  bool is_narrow_ = false;
  ScratchFile file_;
};

/// Puts every box of a region into the slabs that it touches. Uses about `bytes` of memory for buffers. Calls
/// advance() with the numbers of boxes done, from several threads.
template <class C>
std::vector<std::unique_ptr<SlabFile<C>>> distribute(const BoxSource<C>& source, const RegionOf<C>& region,
                                                     const Cuts& cuts, std::uint64_t bytes,
                                                     const std::string& scratch,
                                                     const std::function<void(std::uint64_t)>& advance);

// ---- implementation ----

template <class C>
template <class F>
void BoxSource<C>::each_piece(F&& f) const {
  const std::uint64_t pieces = (size() + kPiece - 1) / kPiece;
  PerThread<std::vector<BoxOf<C>>> memory;
  parallel_ranges(0, pieces, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<BoxOf<C>>& boxes = memory.local();
    for (std::size_t i = begin; i < end; ++i) {
      read(i * kPiece, std::min((i + 1) * kPiece, size()), boxes);
      f(std::span<const BoxOf<C>>(boxes));
    }
  });
}

template <class C>
std::vector<Box> BoxSource<C>::sample() const {
  constexpr std::uint64_t kTogether = 16;
  std::vector<Box> sample;
  std::vector<BoxOf<C>> boxes;
  Sample((size() + kTogether - 1) / kTogether, kSample / kTogether).each([&](std::uint64_t group) {
    read(group * kTogether, std::min((group + 1) * kTogether, size()), boxes);
    for (const BoxOf<C>& box : boxes) {
      Box& as_doubles = sample.emplace_back();
      std::copy(box.begin(), box.end(), as_doubles.begin());
    }
  });
  return sample;
}

template <class C>
void SlabFile<C>::append(std::span<const BoxOf<C>> boxes) {
  const auto write = [&](const auto& all) {
    const auto bytes = std::as_bytes(std::span(all));
    file_.append({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  };
  if constexpr (std::is_same_v<C, std::uint32_t>) {
    if (is_narrow_) {
      std::vector<Narrow> narrow(boxes.size());
      for (std::size_t i = 0; i < boxes.size(); ++i)
        for (unsigned c = 0; c < 6; ++c) narrow[i][c] = std::uint16_t(boxes[i][c] - base_[c % 3]);
      return write(narrow);
    }
  }
  write(boxes);
}

template <class C>
void SlabFile<C>::read(std::uint64_t begin, std::uint64_t end, std::vector<BoxOf<C>>& boxes) const {
  boxes.resize(end - begin);
  const auto read_into = [&](auto& all) {
    const auto bytes = std::as_writable_bytes(std::span(all));
    file_.read_at(begin * bytes_a_box(), {reinterpret_cast<char*>(bytes.data()), bytes.size()});
  };
  if constexpr (std::is_same_v<C, std::uint32_t>) {
    if (is_narrow_) {
      std::vector<Narrow> narrow(boxes.size());
      read_into(narrow);
      for (std::size_t i = 0; i < boxes.size(); ++i)
        for (unsigned c = 0; c < 6; ++c) boxes[i][c] = base_[c % 3] + narrow[i][c];
      return;
    }
  }
  read_into(boxes);
}

template <class C>
std::vector<std::unique_ptr<SlabFile<C>>> distribute(const BoxSource<C>& source, const RegionOf<C>& region,
                                                     const Cuts& cuts, std::uint64_t bytes,
                                                     const std::string& scratch,
                                                     const std::function<void(std::uint64_t)>& advance) {
  const auto axis = unsigned(cuts.axis);
  std::vector<C> at;
  for (const double cut : cuts.at)
    if (C(cut) > region.lo[axis] && C(cut) < region.hi[axis]) at.push_back(C(cut));
  std::vector<std::unique_ptr<SlabFile<C>>> slabs;
  for (std::size_t i = 0; i <= at.size(); ++i) {
    RegionOf<C> own = region;
    if (i > 0) own.lo[axis] = at[i - 1];
    if (i < at.size()) own.hi[axis] = at[i];
    slabs.push_back(std::make_unique<SlabFile<C>>(own, ScratchFile(scratch)));
  }
  using Buffers = std::vector<std::vector<BoxOf<C>>>;  // by slab
  const std::size_t most = std::clamp<std::size_t>(bytes / (thread_count() * slabs.size() * sizeof(BoxOf<C>)),
                                                   64, std::size_t{1} << 15);
  PerThread<Buffers> buffers{[&] {
    Buffers empty(slabs.size());
    for (auto& buffer : empty) buffer.reserve(most);
    return empty;
  }};
  source.each_piece([&](std::span<const BoxOf<C>> boxes) {
    Buffers& mine = buffers.local();
    for (BoxOf<C> box : boxes) {
      const C lo = box[axis], hi = box[axis + 3];
      for (auto slab = std::size_t(std::ranges::upper_bound(at, lo) - at.begin());; ++slab) {
        const RegionOf<C>& own = slabs[slab]->region();
        box[axis] = lo < own.lo[axis] ? just_below(own.lo[axis]) : lo;
        box[axis + 3] = std::min(hi, own.hi[axis]);
        mine[slab].push_back(box);
        if (mine[slab].size() == most) slabs[slab]->append(mine[slab]), mine[slab].clear();
        if (slab == at.size() || hi < at[slab]) break;
      }
    }
    advance(boxes.size());
  });
  buffers.for_each([&](const Buffers& rest) {
    for (std::size_t slab = 0; slab < slabs.size(); ++slab) slabs[slab]->append(rest[slab]);
  });
  return slabs;
}

}  // namespace boxunion

#include "host/vertex_runs.hpp"

#include <algorithm>
#include <queue>
#include <utility>

namespace boxunion {
namespace {

constexpr std::uint64_t kLeastBuffer = 1 << 10, kMostBlock = 1 << 16;  // vertices

/// A run on its way through a merge: a block of it in memory.
class RunReader {
 public:
  RunReader(const ScratchFile& file, std::uint64_t offset, std::uint64_t count, std::uint64_t block)
      : file_(&file), offset_(offset), rest_(count), block_(block) {
    refill();
  }
  bool is_done() const { return next_ == vertices_.size(); }
  const PlacedVertex& front() const { return vertices_[next_]; }
  void pop() {
    if (++next_ == vertices_.size()) refill();
  }

 private:
  void refill() {
    vertices_.resize(std::min(block_, rest_));
    const std::span<PlacedVertex> block = vertices_;
    file_->read_at(offset_, {reinterpret_cast<char*>(block.data()), block.size_bytes()});
    offset_ += block.size_bytes();
    rest_ -= block.size();
    next_ = 0;
  }

  const ScratchFile* file_;
  std::uint64_t offset_, rest_, block_;  // rest: vertices behind the block
  std::vector<PlacedVertex> vertices_;
  std::size_t next_ = 0;
};

}  // namespace

VertexRuns::VertexRuns(std::uint64_t bytes, std::size_t threads, ScratchFile file)
    : bytes_(bytes),
      most_(std::max(kLeastBuffer, bytes / (threads * sizeof(PlacedVertex)))),
      file_(std::move(file)) {}

void VertexRuns::add(std::span<const Vertex> vertices, const Axes& axes) {
  std::vector<PlacedVertex>& buffer = buffers_.local();
  if (buffer.capacity() == 0) buffer.reserve(most_);
  for (const Vertex& v : vertices) {
    if (buffer.size() == most_) flush(buffer);
    buffer.push_back(place(v, axes));
  }
}

void VertexRuns::flush(std::vector<PlacedVertex>& buffer) {
  if (buffer.empty()) return;
  std::sort(buffer.begin(), buffer.end());  // on this thread: the others fill buffers of their own
  const std::uint64_t offset =
      file_.append({reinterpret_cast<const char*>(buffer.data()), buffer.size() * sizeof(PlacedVertex)});
  const std::lock_guard lock(mutex_);
  runs_.push_back({offset, buffer.size()});
  buffer.clear();
}

std::uint64_t VertexRuns::count() const {
  std::uint64_t count = file_.size() / sizeof(PlacedVertex);
  buffers_.for_each([&](const std::vector<PlacedVertex>& buffer) { count += buffer.size(); });
  return count;
}

void VertexRuns::merge(const std::function<void(std::span<const PlacedVertex>)>& f) {
  buffers_.for_each([&](std::vector<PlacedVertex>& buffer) {
    flush(buffer);
    buffer = {};
  });
  const std::uint64_t block =
      std::clamp<std::uint64_t>(bytes_ / ((runs_.size() + 1) * sizeof(PlacedVertex)), 16, kMostBlock);
  std::vector<RunReader> readers;
  readers.reserve(runs_.size());
  const auto later = [&](std::size_t a, std::size_t b) { return readers[b].front() < readers[a].front(); };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> heads(later);
  for (const Run& run : runs_) {
    readers.emplace_back(file_, run.offset, run.count, block);
    heads.push(readers.size() - 1);
  }
  std::vector<PlacedVertex> merged;
  while (!heads.empty()) {
    const std::size_t run = heads.top();
    heads.pop();
    // as long as the run stays ahead of the others, which after sorting by region is often
    do {
      merged.push_back(readers[run].front());
      if (merged.size() == kMostBlock) f(std::exchange(merged, {}));
      readers[run].pop();
    } while (!readers[run].is_done() && (heads.empty() || !later(run, heads.top())));
    if (!readers[run].is_done()) heads.push(run);
  }
  f(merged);
}

}  // namespace boxunion

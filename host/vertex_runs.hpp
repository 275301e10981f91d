#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "core/parallel.hpp"
#include "host/files.hpp"
#include "host/scratch.hpp"

namespace boxunion {

/// Sorts vertices that do not fit memory: what a thread gets goes to a scratch file in sorted runs, which are
/// merged in the end (an external merge sort). 32 bytes a vertex on disk.
class VertexRuns {
 public:
  /// Holds at most about `bytes` of memory, on so many threads.
  VertexRuns(std::uint64_t bytes, std::size_t threads, ScratchFile file);

  /// Takes vertices of a solid with these axes; no vertex may come twice. Thread-safe.
  void add(std::span<const Vertex> vertices, const Axes& axes);
  /// Vertices so far. Not while another thread adds.
  std::uint64_t count() const;
  /// Gives all vertices to f in order, block by block, and gives their memory back. Not while another thread
  /// adds; nothing may be added afterwards.
  void merge(const std::function<void(std::span<const PlacedVertex>)>& f);

 private:
  struct Run {
    std::uint64_t offset, count;
  };
  void flush(std::vector<PlacedVertex>& buffer);

  std::uint64_t bytes_;
  std::size_t most_;  // vertices of a thread's buffer
  ScratchFile file_;
  PerThread<std::vector<PlacedVertex>> buffers_;
  std::mutex mutex_;
  std::vector<Run> runs_;
};

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "boxunion/solid.hpp"

namespace boxunion {

/// Receives the vertices of a union, batch by batch in any order, each vertex once.
class VertexSink {
 public:
  virtual ~VertexSink() = default;
  /// Takes one batch. Called from several threads at once.
  virtual void add(std::span<const Vertex> vertices) = 0;
};

/// Passes on the vertices that a region owns: those at lo <= p < hi on every axis.
class RegionFilter : public VertexSink {
 public:
  /// `next` must outlive the filter.
  RegionFilter(const OrdinalBox& region, VertexSink& next) : region_(region), next_(next) {}

  void add(std::span<const Vertex> vertices) override {
    std::vector<Vertex> owned;
    owned.reserve(vertices.size());
    for (const Vertex& v : vertices)
      if (region_.owns({v.x, v.y, v.z})) owned.push_back(v);
    next_.add(owned);
  }

 private:
  OrdinalBox region_;
  VertexSink& next_;
};

}  // namespace boxunion

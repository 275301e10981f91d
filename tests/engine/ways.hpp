#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "boxunion/union.hpp"
#include "core/solid/vertex_sink.hpp"
#include "tests/device/every_device.hpp"

namespace boxunion {

inline void PrintTo(const Vertex& v, std::ostream* out) {
  *out << '(' << v.x << ' ' << v.y << ' ' << v.z << " mask " << v.mask << ')';
}

/// One way to compute a union.
struct Way {
  std::string name;
  Options options;
  friend void PrintTo(const Way& way, std::ostream* out) { *out << way.name; }
};

/// Methods, devices, shapes, workgroup sizes and cell sizes.
inline std::vector<Way> ways(const std::vector<DeviceInfo>& devices = devices_under_test()) {
  std::vector<Way> all;
  for (const DeviceInfo& device : devices) {
    const auto add = [&](std::string name, Method method, CellKernel kernel, const Tuning& tuning) {
      Way way{device.id + "_" + name, {}};
      std::replace(way.name.begin(), way.name.end(), ':', '_');
      way.options.method = method;
      way.options.kernel = kernel;
      way.options.device = device.id;
      way.options.tuning = tuning;
      all.push_back(way);
    };
    if (device.id == "native") {
      for (const std::uint32_t tile : {31u, 9u, 2u})
        add("slices_tile" + std::to_string(tile), Method::slices, {}, {.tile_coordinates = tile});
      for (const std::uint32_t cell : {0u, 1u, 3u, 4u, 100u, 1u << 19}) {
        const std::string size = std::to_string(cell);
        add("occupancy_cell" + size, Method::cells, CellKernel::occupancy, {.cell = cell});
        add("faces_cell" + size, Method::cells, CellKernel::faces, {.cell = cell});
      }
      for (const std::uint32_t boxes : {1u, 15u, 64u})
        add("occupancy_of" + std::to_string(boxes), Method::cells, CellKernel::occupancy,
            {.cell_boxes = boxes});
      continue;
    }
    for (const std::uint32_t workgroup : {1, 8, 32}) {
      const std::string size = std::to_string(workgroup);
      for (const Shape shape : {Shape::group, Shape::item}) {
        const std::string name = (shape == Shape::group ? "group" : "item") + size;
        const Tuning tuning{.shape = shape,
                            .workgroup = workgroup,
                            .tile_coordinates = workgroup == 8 ? 5u : 31u,
                            .cell = workgroup == 8 ? 3u : 0u};
        add("slices_" + name, Method::slices, {}, tuning);
        if (workgroup == 8 || (workgroup == 32) == (shape == Shape::group))
          add("occupancy_" + name, Method::cells, CellKernel::occupancy, tuning);
        if (workgroup == 8) add("faces_" + name, Method::cells, CellKernel::faces, tuning);
      }
    }
  }
  return all;
}

inline std::string way_name(const testing::TestParamInfo<Way>& info) {
  return info.param.name;
}

}  // namespace boxunion

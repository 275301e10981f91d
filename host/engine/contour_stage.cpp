#include "host/engine/contour_stage.hpp"

#include <algorithm>
#include <cstring>

#include "boxunion/error.hpp"
#include "host/device/buffers.hpp"
#include "host/device/kernels.hpp"
#include "host/tuning/tuning.hpp"
#include "kernels/contract.h"

namespace boxunion {
namespace {

using u32 = std::uint32_t;
struct ContourParameters {
  CONTOUR_PARAMETERS
};

static_assert(sizeof(Tiles::Tile) == CONTOUR_TILE_WORDS * sizeof(u32) &&
              sizeof(SlabRectangle) == CONTOUR_RECTANGLE_WORDS * sizeof(u32) &&
              sizeof(ContourVertex) == CONTOUR_VERTEX_WORDS * sizeof(u32));

}  // namespace

ContourStage::ContourStage(Device& device, const Tuning& tuning)
    : device_(device),
      kernel_(load(device, kernels::contour(), tuning)),
      total_(device.allocate(TOTAL_WORDS * sizeof(u32))) {}

void ContourStage::run(const Tiles& tiles, std::vector<ContourVertex>& vertices,
                       std::vector<std::size_t>& offsets) {
  vertices.clear();
  offsets.assign(1, 0);
  const std::size_t most_rectangles =
      std::min<std::size_t>(device_.info().max_buffer_bytes / sizeof(SlabRectangle), std::size_t{1} << 22);
  for (std::size_t first = 0; first < tiles.tiles.size();) {
    std::size_t last = first, rectangles = 0;
    do {
      rectangles += tiles.tiles[last++].count;
    } while (last < tiles.tiles.size() && rectangles + tiles.tiles[last].count <= most_rectangles &&
             last - first < most_rectangles / 2);
    run_range(tiles, first, last, vertices, offsets);
    first = last;
  }
}

void ContourStage::run_range(const Tiles& tiles, std::size_t first, std::size_t last,
                             std::vector<ContourVertex>& vertices, std::vector<std::size_t>& offsets) {
  const u32 count = u32(last - first);
  const std::size_t first_rectangle = tiles.tiles[first].first;
  const std::size_t rectangles = tiles.tiles[last - 1].first + tiles.tiles[last - 1].count - first_rectangle;
  reserve(device_, tile_, count * sizeof(Tiles::Tile));
  reserve(device_, rectangle_, rectangles * sizeof(SlabRectangle));
  reserve(device_, found_, count * CONTOUR_FOUND_WORDS * sizeof(u32));
  const std::size_t most = device_.info().max_buffer_bytes / sizeof(ContourVertex);
  reserve(device_, vertex_, std::min(most, 4 * rectangles + 64) * sizeof(ContourVertex));

  const auto tile = tile_->view<Tiles::Tile>();
  for (u32 i = 0; i < count; ++i) {
    tile[i] = tiles.tiles[first + i];
    tile[i].first -= u32(first_rectangle);
  }
  std::memcpy(rectangle_->view<SlabRectangle>().data(), tiles.rectangles.data() + first_rectangle,
              rectangles * sizeof(SlabRectangle));
  device_.upload(*tile_, count * sizeof(Tiles::Tile));
  device_.upload(*rectangle_, rectangles * sizeof(SlabRectangle));

  u32 total = 0;
  for (bool fits = false; !fits;) {
    const std::size_t capacity = vertex_->bytes() / sizeof(ContourVertex);
    const ContourParameters parameters{count, u32(std::min<std::size_t>(capacity, 0xffffffffu)), 2};
    device_.clear(*total_, total_->bytes());
    Buffer* const buffers[] = {tile_.get(), rectangle_.get(), found_.get(), vertex_.get(), total_.get()};
    device_.dispatch(*kernel_, buffers, std::as_bytes(std::span(&parameters, 1)), count);
    device_.download(*total_, 0, total_->bytes());
    device_.wait();
    total = total_->view<u32>()[TOTAL_FOUND];
    if (total_->view<u32>()[TOTAL_CUT_SHORT] != 0)
      throw Error(ErrorKind::device, "the device cuts long loops short");
    fits = total <= parameters.capacity;
    if (fits) break;
    if (total <= most) {
      reserve(device_, vertex_, total * sizeof(ContourVertex));
    } else if (count > 1) {
      const std::size_t middle = first + count / 2;
      run_range(tiles, first, middle, vertices, offsets);
      return run_range(tiles, middle, last, vertices, offsets);
    } else {
      throw Error(ErrorKind::device, "the contour of one tile exceeds the device's largest buffer");
    }
  }
  device_.download(*found_, 0, count * CONTOUR_FOUND_WORDS * sizeof(u32));
  device_.download(*vertex_, 0, total * sizeof(ContourVertex));
  device_.wait();

  const auto found = found_->view<u32>();
  const auto vertex = vertex_->view<ContourVertex>();
  for (u32 i = 0; i < count; ++i) {
    const u32 begin = found[CONTOUR_FOUND_WORDS * i], size = found[CONTOUR_FOUND_WORDS * i + 1];
    if (size == CONTOUR_CROWDED || begin > total || size > total - begin)
      throw Error(ErrorKind::device, "the contour kernel gave an impossible result");
    vertices.insert(vertices.end(), vertex.begin() + begin, vertex.begin() + begin + size);
    offsets.push_back(vertices.size());
  }
}

}  // namespace boxunion

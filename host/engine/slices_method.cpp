#include "host/engine/slices_method.hpp"

#include <algorithm>

#include "boxunion/error.hpp"
#include "core/base/parallel.hpp"
#include "core/slices/slices.hpp"
#include "core/slices/xor_merge.hpp"
#include "host/engine/contour_stage.hpp"
#include "host/engine/resilient.hpp"
#include "host/engine/stopwatch.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kRectanglesPerBatch = std::size_t{1} << 20;

/// The tiles of a batch of slabs. Slab i has tiles [first_tile[i], first_tile[i + 1]).
struct BatchTiles : Tiles {
  std::vector<std::size_t> first_tile;
};

BatchTiles cut_batch(const SlabBatch& batch, std::uint32_t max_coordinates) {
  std::vector<Tiles> by_slab(batch.slabs());
  parallel_for_each(0, batch.slabs(), 1, [&](std::size_t i) {
    cut_tiles(std::span(batch.rectangles).subspan(batch.offsets[i], batch.offsets[i + 1] - batch.offsets[i]),
              max_coordinates, by_slab[i]);
  });
  BatchTiles all;
  all.first_tile.assign(1, 0);
  for (const Tiles& slab : by_slab) {
    const std::size_t shift = all.rectangles.size();
    if (shift + slab.rectangles.size() > 0xffffffffu)
      throw Error(ErrorKind::resources, "a slab has more than 2^32 rectangles in its tiles");
    for (Tiles::Tile tile : slab.tiles) {
      tile.first += std::uint32_t(shift);
      all.tiles.push_back(tile);
    }
    all.rectangles.insert(all.rectangles.end(), slab.rectangles.begin(), slab.rectangles.end());
    all.first_tile.push_back(all.tiles.size());
  }
  return all;
}

}  // namespace

void unite_by_slices(std::vector<OrdinalBox> boxes, const Options& options, VertexSink& sink,
                     Report& report) {
  report.method = "slices";
  report.kernel = "contour";
  const std::uint32_t max_coordinates = options.tuning.tile_coordinates
                                            ? std::min(options.tuning.tile_coordinates, kMostTileCoordinates)
                                            : kMostTileCoordinates;
  Resilient<ContourStage> contour(options);
  Stopwatch watch(report);
  SlabSweep sweep(std::move(boxes));
  const std::vector<std::uint32_t>& x = sweep.x();
  PerThread<XorMerge> merges([&] { return XorMerge(std::uint32_t(x.size())); });
  watch.lap("slabs");

  SlabBatch batch;
  std::vector<ContourVertex> vertices;
  std::vector<std::size_t> offsets;
  std::vector<ContourVertex> last_contour;  // contour of the slab below the batch
  while (sweep.next(kRectanglesPerBatch, batch)) {
    Interruptible::check();
    const BatchTiles tiles = cut_batch(batch, max_coordinates);
    watch.lap("tiles");
    contour.run([&](ContourStage& stage) { stage.run(tiles, vertices, offsets); });
    watch.lap("contours");

    const auto slab = [&](std::size_t i) {
      const std::size_t begin = offsets[tiles.first_tile[i]], end = offsets[tiles.first_tile[i + 1]];
      return std::span(vertices).subspan(begin, end - begin);
    };
    parallel_for_each(0, batch.slabs(), 1, [&](std::size_t i) { std::ranges::sort(slab(i), kContourOrder); });
    const bool is_last = batch.first + batch.slabs() == sweep.slabs();
    parallel_ranges(0, batch.slabs() + is_last, 1, [&](std::size_t begin, std::size_t end) {
      XorMerge& merge = merges.local();
      Array<Vertex> out;
      for (std::size_t i = begin; i < end; ++i) {
        const std::span<const ContourVertex> lower = i > 0 ? slab(i - 1) : std::span(last_contour);
        const std::span<const ContourVertex> upper = i < batch.slabs() ? slab(i) : std::span<ContourVertex>();
        merge(lower, upper, sweep.z(std::uint32_t(batch.first + i)), out);
      }
      for (Vertex& v : out) v.x = x[v.x];
      sink.add(out);
    });
    const auto top = slab(batch.slabs() - 1);
    last_contour.assign(top.begin(), top.end());
    watch.lap("merge");
    if (options.progress) options.progress(double(batch.first + batch.slabs()) / sweep.slabs());
  }
  report.device = contour.device().id;
}

}  // namespace boxunion

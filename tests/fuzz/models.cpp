// Boxes from any bytes: extreme vertices, disjoint boxes and components convert back to the same solid.

#include <cstdint>

#include "boxunion/components.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/voxels.hpp"
#include "core/boundary/faces.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace boxunion::fuzz {
namespace {

/// The voxels covered by boxes with coordinates 0 .. range.
Volume voxels_of(const std::vector<IntegerBox>& boxes, int range) {
  Volume volume;
  const auto n = std::size_t(range);
  volume.grid.size = {n, n, n};
  volume.inside.assign(n * n * n, 0);
  for (const IntegerBox& b : boxes)
    for (int z = b[2]; z < b[5]; ++z)
      for (int y = b[1]; y < b[4]; ++y)
        for (int x = b[0]; x < b[3]; ++x)
          volume.inside[(std::size_t(z) * n + std::size_t(y)) * n + std::size_t(x)] = 1;
  return volume;
}

void check(const std::vector<IntegerBox>& boxes, int range, const AxisOrder& order, BoxModel model) {
  const Solid solid = unite(boxes, native());
  const Evm evm = make_evm(solid, order);
  expect(make_solid(evm).vertices == solid.vertices);
  expect(reorder(evm, {0, 1, 2}).vertices == make_evm(solid, {0, 1, 2}).vertices);

  const Volume volume = voxels_of(boxes, range);
  const Decomposition disjoint = decompose(evm, model);
  expect(count_boxes(evm, model) == disjoint.boxes.size());
  expect(make_evm(disjoint).vertices == evm.vertices);
  for (const Connectivity connectivity : {Connectivity::faces, Connectivity::points}) {
    const Labels labels = label_components(find_neighbors(disjoint, connectivity));
    std::vector<std::uint32_t> of_voxels(volume.inside.size());
    const auto components = label_voxels(volume, connectivity, of_voxels);
    expect(labels.count == components.size());
    std::uint64_t voxels = 0, volumes = 0;
    for (const VoxelComponent& component : components) voxels += component.voxels;
    for (const Component& component : measure_components(disjoint, labels))
      volumes += std::uint64_t(component.volume);
    expect(voxels == volumes);
    if (connectivity == Connectivity::faces)
      expect(make_brep(solid, NonManifold::keep).shells.bodies == labels.count);
  }
}

}  // namespace
}  // namespace boxunion::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace boxunion::fuzz;
  Bytes input(bytes, count);
  const int range = 1 + input.below(12);
  const boxunion::AxisOrder order = input.one_of(boxunion::kAxisOrders);
  const auto model = input.one_of(std::array{boxunion::BoxModel::oudb, boxunion::BoxModel::cudb});
  check(take_boxes(input, 40, range), range, order, model);
  return 0;
}

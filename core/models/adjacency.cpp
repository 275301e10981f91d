#include <vector>

#include "boxunion/components.hpp"
#include "core/base/interruptible.hpp"
#include "core/models/box_faces.hpp"

namespace boxunion {
namespace {

/// A box, and a neighbor that begins where it ends.
struct Pair {
  std::uint32_t below, above;
};

/// Lists of the pairs that for_each_entry(add) passes to add(box, neighbor), in its order. Calls
/// for_each_entry twice.
template <class F>
NeighborLists make_lists(std::size_t boxes, std::size_t entries, F&& for_each_entry) {
  NeighborLists lists;
  with_memory("the neighbors of all boxes", 4 * entries + 8 * boxes, [&] {
    lists.boxes.resize(entries);
    lists.offsets.assign(boxes + 2, 0);
  });
  std::uint64_t* const next = lists.offsets.data() + 1;  // start of box i; later of box i + 1
  for_each_entry([&](std::uint32_t box, std::uint32_t) { ++next[box + 1]; });
  interruptible_loop(boxes, [&](std::size_t i) { next[i + 1] += next[i]; });
  for_each_entry([&](std::uint32_t box, std::uint32_t neighbor) { lists.boxes[next[box]++] = neighbor; });
  lists.offsets.pop_back();
  return lists;
}

/// The same pairs seen from the neighbors, ascending.
NeighborLists transposed(const NeighborLists& lists) {
  const std::size_t boxes = lists.offsets.size() - 1;
  return make_lists(boxes, lists.boxes.size(), [&](auto&& add) {
    interruptible_loop(boxes, [&](std::size_t i) {
      for (const std::uint32_t neighbor : lists[i]) add(neighbor, std::uint32_t(i));
    });
  });
}

}  // namespace

Adjacency find_neighbors(const Decomposition& decomposition, Connectivity connectivity) {
  validate(connectivity);
  const std::size_t boxes = decomposition.boxes.size();
  Adjacency adjacency;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    PerThread<std::vector<Pair>> pairs;
    join_boxes<FacePairs::all>(decomposition, connectivity, axis, [&] {
      return [&found = pairs.local()](std::uint32_t below, std::uint32_t above) {
        found.push_back({below, above});
      };
    });
    std::size_t count = 0;
    pairs.for_each([&](const std::vector<Pair>& part) { count += part.size(); });
    const NeighborLists forward = make_lists(boxes, count, [&](auto&& add) {
      pairs.for_each([&](const std::vector<Pair>& part) {
        interruptible_loop(part.size(), [&](std::size_t i) { add(part[i].below, part[i].above); });
      });
    });
    adjacency.backward[axis] = transposed(forward);
    adjacency.forward[axis] = transposed(adjacency.backward[axis]);  // this also sorts the lists
  }
  return adjacency;
}

}  // namespace boxunion

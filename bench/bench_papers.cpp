// The experiment of López Monterde et al., figures 6 and 7: seconds to the B-rep of random sets of boxes, by
// their number and density. Prints a Markdown table. Times are medians over the sets.
//
// Density is theirs: (n r / 2 - n^2) / (n^3 - n^2) for n boxes and r rectangles in all slices together. With
// a slice after each of the 2 n faces normal to z, this is the mean number of rectangles in a slice, on a
// scale from 1 (0) to n (1). Random boxes have random ends on each axis, which gives about 1/3. Sparser sets
// have a fixed length along z.

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bench/program.hpp"
#include "bench/timing.hpp"
#include "boxunion/union.hpp"
#include "core/boundary/faces.hpp"

namespace boxunion {
namespace {

constexpr int kUniverse = 1 << 20;
constexpr double kRandomEnds = 1;                              // instead of a length along z
constexpr double kLengths[] = {0.01, 0.05, 0.2, kRandomEnds};  // in universes

/// Boxes with random ends on x and y. On z, the ends are `length` universes apart.
std::vector<IntegerBox> random_boxes(std::size_t count, double length, int seed) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const auto below = [&](int end) { return int(random() % std::uint64_t(end)); };
  std::vector<IntegerBox> boxes(count);
  for (IntegerBox& box : boxes)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      int low = below(kUniverse), high = below(kUniverse);
      if (axis == 2 && length < kRandomEnds) {
        const int edge = int(length * kUniverse);
        low = below(kUniverse - edge);
        high = low + edge;
      }
      box[axis] = std::min(low, high);
      box[axis + 3] = std::max(low, high) + (low == high ? 1 : 0);
    }
  return boxes;
}

/// The paper's density, with a slice after each face normal to z.
double density(const std::vector<IntegerBox>& boxes) {
  std::vector<std::pair<int, int>> faces;  // z, and the number of rectangles that begin there
  for (const IntegerBox& box : boxes) {
    faces.emplace_back(box[2], 1);
    faces.emplace_back(box[5], -1);
  }
  std::sort(faces.begin(), faces.end());
  double rectangles = 0;
  int now = 0;
  for (const auto& [z, change] : faces) rectangles += now += change;
  const auto n = double(boxes.size());
  return (n * rectangles / 2 - n * n) / (n * n * n - n * n);
}

constexpr std::size_t kMostSliced = 500;  // their method takes seconds for more

/// Seconds to the B-rep by a method. `vertices` is compared between methods.
double seconds_by(Method method, const BoxSet& boxes, std::size_t& vertices) {
  return median_seconds(method == Method::cells ? 3 : 1, [&] {
    const Solid solid = unite(boxes, {.method = method, .device = "native"});
    vertices = make_brep(solid, NonManifold::keep).points.size();
  });
}

void run(const Request& request, Tables& tables) {
  tables.begin("boxes", {"length", "boxes", "sets", "density", "vertices", "cells", "slices"});
  for (const double length : kLengths)
    for (const std::size_t count : request.counts) {
      std::vector<double> densities, vertices, cells, slices;
      for (int set = 0; set < request.runs; ++set) {
        const std::vector<IntegerBox> boxes = random_boxes(count, length, set);
        std::size_t of_cells = 0, of_slices = 0;
        cells.push_back(seconds_by(Method::cells, boxes, of_cells));
        if (count <= kMostSliced) {
          slices.push_back(seconds_by(Method::slices, boxes, of_slices));
          if (of_cells != of_slices) throw Error(ErrorKind::device, "the methods disagree");
        }
        densities.push_back(density(boxes));
        vertices.push_back(double(of_cells));
      }
      tables.add(length, count, request.runs, median(densities), median(vertices), median(cells),
                 slices.empty() ? std::nan("") : median(slices));
    }
}

}  // namespace
}  // namespace boxunion

int main(int argc, char** argv) {
  return boxunion::run_benchmark(
      argc, argv, "Times the way to the B-rep of random sets of boxes, by their number and density.",
      {.runs = 20, .counts = {10, 20, 50, 100, 200, 500, 1000, 2000}, .sections = {}}, boxunion::run);
}

#include "host/bench/device_check.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <span>
#include <utility>

#include "boxunion/error.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/octants.hpp"
#include "boxunion/union.hpp"
#include "core/base/interruptible.hpp"
#include "core/cells/expression.hpp"
#include "core/solid/mass_sink.hpp"
#include "core/solid/solid_sink.hpp"
#include "host/bench/bench_problem.hpp"
#include "host/bench/kernel_bench.hpp"

namespace boxunion {
namespace {

constexpr std::int32_t kGrid = 16;           // edge of the grid of the native cases
constexpr std::uint32_t kProblemCells = 64;  // cells of a case on which devices are compared with native

/// A union of boxes, or one set of boxes without another, computed by testing every point of a grid.
class GridCase {
 public:
  GridCase(Expression expression, std::uint64_t boxes, std::int64_t longest, std::uint64_t seed)
      : expression_(std::move(expression)) {
    for (std::size_t i = 0; i < expression_.names().size(); ++i)
      sets_.push_back(collect(generate_boxes(boxes, 1, longest, kGrid, seed + i)));
    fill();
    find_vertices();
  }

  /// Describes what is wrong with the vertices that the engine finds with these options; empty if they are
  /// right.
  std::string check_vertices(const Options& options) const {
    const Solid solid = combine(expression_, sets_, options);
    std::vector<Vertex> found;
    for (const Vertex& v : solid.vertices)
      found.push_back({at(solid.axes[0], v.x), at(solid.axes[1], v.y), at(solid.axes[2], v.z), v.mask});
    return found == vertices_ ? "" : "wrong result: its vertices are not those of brute force";
  }
  /// The same for the mass properties.
  std::string check_mass(const Options& options) const {
    MassSink expected(grid_axes());
    expected.add(vertices_);
    const MassProperties found = measure(expression_, sets_, options);
    return found == expected.result() && found.volume == double(filled_)
               ? ""
               : "wrong result: its mass properties are not those of brute force";
  }

 private:
  // Coordinates are 0 .. kGrid, so ordinals are 1 .. kGrid + 1. A layer of empty cells surrounds them.
  static constexpr std::int32_t kEdge = kGrid + 2;
  static std::size_t index(std::int32_t x, std::int32_t y, std::int32_t z) {
    return std::size_t((z * kEdge + y) * kEdge + x);
  }
  static Axes grid_axes() {
    const Axis axis = Axis::lattice(-1, 0, kGrid + 1);
    return {axis, axis, axis};
  }
  static std::uint32_t at(const Axis& axis, std::uint32_t ordinal) {
    return std::uint32_t(axis.coordinate(ordinal)) + 1;
  }

  void fill() {
    for (std::size_t i = 0; i < sets_.size(); ++i)
      for (std::size_t b = 0; b < sets_[i].size(); ++b) {
        std::array<std::int32_t, 6> c{};
        for (std::size_t k = 0; k < 6; ++k) c[k] = std::int32_t(sets_[i][b][k]) + 1;
        for (std::int32_t z = c[2]; z < c[5]; ++z)
          for (std::int32_t y = c[1]; y < c[4]; ++y)
            for (std::int32_t x = c[0]; x < c[3]; ++x) inside_[index(x, y, z)] = i == 0;
      }
    filled_ = std::size_t(std::ranges::count(inside_, true));
  }
  void find_vertices() {
    for (std::int32_t z = 0; z <= kGrid; ++z)
      for (std::int32_t y = 0; y <= kGrid; ++y)
        for (std::int32_t x = 0; x <= kGrid; ++x) {
          std::uint32_t mask = 0;
          for (std::int32_t k = 0; k < 8; ++k)
            mask |= std::uint32_t(inside_[index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2))]) << k;
          if (is_vertex(mask))
            vertices_.push_back({std::uint32_t(x) + 1, std::uint32_t(y) + 1, std::uint32_t(z) + 1, mask});
        }
  }
  /// True if the mask is constant along none of the axes.
  static bool is_vertex(std::uint32_t mask) {
    const auto varies = [&](std::uint32_t low, int shift) { return (mask & low) != (mask >> shift & low); };
    return varies(0b01010101, 1) && varies(0b00110011, 2) && varies(0b00001111, 4);
  }

  Expression expression_;
  std::vector<BoxSet> sets_;
  std::vector<bool> inside_ = std::vector<bool>(std::size_t(kEdge) * kEdge * kEdge);
  std::size_t filled_ = 0;
  std::vector<Vertex> vertices_;
};

/// Calls f, which describes a failure. An exception also counts as one, except for an interrupt.
template <class F>
std::string failure_of(F&& f) {
  try {
    return f();
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::interrupted) throw;
    return error.what();
  } catch (const std::bad_alloc&) {
    return "out of memory";
  }
}

}  // namespace

bool DeviceCheck::is_ok() const {
  return failure.empty() &&
         std::ranges::all_of(kernels, [](const KernelCheck& k) { return k.failure.empty(); });
}

std::vector<KernelCheck> check_kernels(Device& device, const std::shared_ptr<const TunedLaunches>& tuned) {
  std::vector<KernelCheck> checks;
  for (const std::string_view kernel : benchmark_kernels()) {
    KernelCheck& check = checks.emplace_back(KernelCheck{std::string(kernel)});
    for (const Density density : {Density::sparse, Density::middle, Density::dense}) {
      if (!check.failure.empty()) break;
      check.failure = failure_of([&] {
        const auto problem = make_problem(check.kernel, density, kProblemCells);
        const auto runner = problem->make_runner(device, {.tuned = tuned});
        const bool right = runner->check();
        check.ran_natively |= runner->ran_natively();
        return std::string(right ? "" : "wrong result: it differs from the native device's");
      });
    }
  }
  return checks;
}

std::vector<KernelCheck> check_native_kernels() {
  std::vector<KernelCheck> checks;
  for (const std::string_view kernel : benchmark_kernels()) {
    KernelCheck& check = checks.emplace_back(KernelCheck{std::string(kernel)});
    Options options{.device = "native"};
    if (kernel == "contour") options.method = Method::slices;
    if (kernel == "cell_faces") options.kernel = CellKernel::faces;
    const bool sums = kernel.ends_with("_sums");
    const Expression expression =
        kernel.starts_with("cell_boolean") ? Expression::parse("a not b") : Expression::one_operand();
    for (const std::uint64_t boxes : {4, 40, 400})
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        if (!check.failure.empty()) break;
        check.failure = failure_of([&] {
          const GridCase grid(expression, boxes, boxes < 100 ? kGrid / 2 : 4, seed);
          return sums ? grid.check_mass(options) : grid.check_vertices(options);
        });
      }
  }
  return checks;
}

std::vector<DeviceCheck> check_devices(const std::function<void(const DeviceCheck&)>& done,
                                       const std::shared_ptr<const TunedLaunches>& tuned) {
  std::vector<DeviceCheck> checks;
  for (const DeviceInfo& info : list_devices()) {
    Interruptible::check();
    DeviceCheck& check = checks.emplace_back(DeviceCheck{info});
    if (info.id == "native") check.kernels = check_native_kernels();
    check.failure = failure_of([&] {
      const std::unique_ptr<Device> device = open_device(info.id);
      for (const KernelCheck& kernel : check_kernels(*device, tuned)) {
        const auto known = std::ranges::find(check.kernels, kernel.kernel, &KernelCheck::kernel);
        if (known == check.kernels.end())
          check.kernels.push_back(kernel);
        else if (known->failure.empty())
          known->failure = kernel.failure;
      }
      return std::string();
    });
    done(check);
  }
  return checks;
}

}  // namespace boxunion

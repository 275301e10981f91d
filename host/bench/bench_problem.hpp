#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "host/bench/kernel_bench.hpp"

namespace boxunion {

/// A problem made ready on a device. Members throw as the device does.
class BenchRunner {
 public:
  virtual ~BenchRunner() = default;
  /// Computes the problem and says whether the result is the native one.
  virtual bool check() = 0;
  /// Computes the problem, from batch in host memory to result in host memory.
  virtual void run() = 0;
  /// Did anything so far run natively, because the device could not?
  virtual bool ran_natively() const { return false; }
};

/// Cells (or tiles) as the product hands them to a device, and their result by the native device.
class BenchProblem {
 public:
  virtual ~BenchProblem() = default;
  /// The runner refers to the device and the problem.
  virtual std::unique_ptr<BenchRunner> make_runner(Device& device, const Tuning& tuning) const = 0;
  /// The kernel's name and the counts and bytes of a case.
  const BenchCase& describe() const { return description_; }

 protected:
  BenchCase description_;
};

/// Makes a problem of about `size` cells out of random cubes, the same on every machine. Sums have fewer if
/// that many cells of sparse cubes need too many cubes: lone cubes and pairs need no kernel.
std::unique_ptr<BenchProblem> make_problem(const std::string& kernel, Density density, std::uint32_t size);

}  // namespace boxunion

#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "host/bench/kernel_bench.hpp"

namespace boxunion {

/// A problem loaded on a device. Members throw as the device does.
class BenchRunner {
 public:
  virtual ~BenchRunner() = default;
  /// Computes the problem. Returns true if the result equals the native one.
  virtual bool check() = 0;
  /// Computes the problem, from batch in host memory to result in host memory.
  virtual void run() = 0;
  /// True if anything so far ran natively because the device could not run it.
  virtual bool ran_natively() const { return false; }
};

/// Cells (or tiles) in the form that the product passes to a device, and the native device's result.
class BenchProblem {
 public:
  virtual ~BenchProblem() = default;
  /// The runner keeps references to the device and the problem.
  virtual std::unique_ptr<BenchRunner> make_runner(Device& device, const Tuning& tuning) const = 0;
  /// The name of the kernel, and the counts and bytes of a case.
  const BenchCase& describe() const { return description_; }

 protected:
  BenchCase description_;
};

/// Makes a problem of about `size` cells from random cubes, the same on every machine. Problems for sums have
/// fewer cells if so many cells of sparse cubes would need too many cubes, because lone cubes and pairs need
/// no kernel.
std::unique_ptr<BenchProblem> make_problem(const std::string& kernel, Density density, std::uint32_t size);

}  // namespace boxunion

#include "core/base/instruction_set.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace boxunion {
namespace {

/// The tests run once more with BOXUNION_CPU=baseline.
TEST(InstructionSet, IsWhatTheEnvironmentNamesOrTheBest) {
  const char* const value = std::getenv("BOXUNION_CPU");
  const std::string name = value ? value : "";
#ifdef __x86_64__
  const bool has_avx2 = __builtin_cpu_supports("avx2");
#else
  const bool has_avx2 = false;
#endif
  EXPECT_EQ(to_string(instruction_set()), !name.empty() ? name : has_avx2 ? "x86-64-v3" : "baseline");
}

}  // namespace
}  // namespace boxunion

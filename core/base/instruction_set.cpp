#include "core/base/instruction_set.hpp"

#include <cstdlib>
#include <string>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

bool runs_x86_64_v3() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
         __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

InstructionSet choose() {
  const InstructionSet best = runs_x86_64_v3() ? InstructionSet::x86_64_v3 : InstructionSet::baseline;
  const char* const value = std::getenv("BOXUNION_CPU");
  const std::string_view name = value ? value : "";
  if (name.empty()) return best;
  for (const InstructionSet set : {InstructionSet::baseline, InstructionSet::x86_64_v3})
    if (name == to_string(set)) {
      if (set <= best) return set;
      throw Error(ErrorKind::usage, "BOXUNION_CPU: this CPU does not run " + std::string(name));
    }
  throw Error(ErrorKind::usage,
              "BOXUNION_CPU: expected baseline or x86-64-v3, found '" + std::string(name) + "'");
}

}  // namespace

InstructionSet instruction_set() {
  static const InstructionSet set = choose();
  return set;
}

std::string_view to_string(InstructionSet set) {
  return set == InstructionSet::x86_64_v3 ? "x86-64-v3" : "baseline";
}

}  // namespace boxunion

#pragma once

#include <string_view>

namespace boxunion {

/// The instruction sets for which the inner loops are compiled. The results are the same to the last bit.
enum class InstructionSet {
  baseline,  ///< supported by every CPU of this kind
  x86_64_v3  ///< AVX2, BMI and FMA
};

/// The instruction set in use: the one that BOXUNION_CPU names ("baseline" or "x86-64-v3"), or the best that
/// this CPU supports. The environment is read once. Throws Error(usage) if BOXUNION_CPU names anything else,
/// or one that this CPU lacks.
InstructionSet instruction_set();

std::string_view to_string(InstructionSet set);

}  // namespace boxunion

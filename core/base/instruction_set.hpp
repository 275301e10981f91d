#pragma once

#include <string_view>

namespace boxunion {

/// The instruction sets that the inner loops are compiled for; the results are the same to the last bit.
enum class InstructionSet {
  baseline,  ///< whatever every CPU of this kind has
  x86_64_v3  ///< AVX2, BMI and FMA
};

/// The one in use: what BOXUNION_CPU names ("baseline" or "x86-64-v3"), or the best that this CPU runs. The
/// environment is read once. Throws Error(usage) where BOXUNION_CPU names something else, or what this CPU
/// lacks.
InstructionSet instruction_set();

std::string_view to_string(InstructionSet set);

}  // namespace boxunion

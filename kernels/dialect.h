// One kernel text in three languages: OpenCL C 1.2, GLSL 4.60 (compiled to SPIR-V) and C++20.
//
// A kernel is written as
//
//   #include "dialect.h"
//   PARAMETERS_BEGIN u32 count; PARAMETERS_END
//   KERNEL(name)
//   IN(0, u32, first)  OUT(1, u32, result)  INOUT(2, u32, total)      buffers, in order of binding
//   KERNEL_LOCALS
//   SHARED(u32, scratch, 32)                                          memory of one work unit
//   KERNEL_BODY
//     if (UNIT >= p.count) return;                                    more units may run than requested
//     LANES(i, 32u) scratch[i] = ...;                                 a loop shared by the unit's lanes
//     SYNC;
//     ONE_LANE total[0] += ...;
//     STORE_SUM(result[UNIT], scratch, value);                        sum of a value over the unit's lanes
//   KERNEL_END
//
// UNIT is the index of the work unit. In shape GROUP a workgroup serves it, in shape ITEM (-DITEM) a work-item, in C++
// a thread. For a thread, LANES is a plain loop, SHARED is an array of the thread, and SYNC does nothing.
// README.md lists what a kernel may and may not use.
#ifndef BOXUNION_DIALECT_H
#define BOXUNION_DIALECT_H

#include "contract.h"

#if defined(VULKAN) // GLSL: the compiler defines VULKAN
#define u32 uint
#define u64 uint64_t
#define U32(x) uint(x)
#define U64(x) uint64_t(x)
#define FN
#define PARAMETERS_BEGIN layout(push_constant, std430) uniform ParameterBlock {
#define PARAMETERS_END } p;
#define KERNEL(name)
#define IN(binding_, T, name) layout(set = 0, binding = binding_, std430) restrict readonly buffer Buffer_##name { T name[]; };
#define OUT(binding_, T, name) layout(set = 0, binding = binding_, std430) restrict buffer Buffer_##name { T name[]; };
#define INOUT(binding_, T, name) OUT(binding_, T, name)
#define KERNEL_LOCALS layout(local_size_x_id = 0) in;
#define KERNEL_BODY void main() {
#define KERNEL_END }
#define POPCOUNT(x) U32(bitCount(x))
#define LOWEST_BIT(x) U32(findLSB(x))
#define HIGHEST_BIT(x) U32(findMSB(x))
#define POPCOUNT64(x) U32(bitCount(U32(x)) + bitCount(U32((x) >> 32)))
#define LOWEST_BIT64(x) (U32(x) != 0u ? LOWEST_BIT(U32(x)) : 32u + LOWEST_BIT(U32((x) >> 32)))
#define GLOBAL_FETCH_ADD(old, target, value) u32 old = atomicAdd(target, value)
#define GROUP_INDEX (gl_WorkGroupID.x + gl_NumWorkGroups.x * gl_WorkGroupID.y)
#define LANE gl_LocalInvocationIndex
#define LANE_COUNT gl_WorkGroupSize.x
#define SHARED_MEMORY shared
#define BARRIER memoryBarrierShared(); barrier()
#define ATOMIC_ADD(target, value) atomicAdd(target, value)
#define ATOMIC_OR(target, value) atomicOr(target, value)

#elif defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__) // OpenCL C; WORKGROUP comes with the build
#ifndef WORKGROUP
#define WORKGROUP 32
#endif
#define u32 uint
#define u64 ulong
#define U32(x) ((uint)(x))
#define U64(x) ((ulong)(x))
#define FN inline __attribute__((always_inline))
#define PARAMETERS_BEGIN typedef struct {
#define PARAMETERS_END } Parameters;
#define KERNEL(name) __kernel __attribute__((reqd_work_group_size(WORKGROUP, 1, 1))) void name(
#define IN(binding, T, name) __global const T *restrict name,
#define OUT(binding, T, name) __global T *restrict name,
#define INOUT(binding, T, name) OUT(binding, T, name)
#define KERNEL_LOCALS const Parameters p) {
#define KERNEL_BODY
#define KERNEL_END }
#define POPCOUNT(x) U32(popcount(x))
#define LOWEST_BIT(x) (31u - U32(clz((x) & (0u - (x)))))
#define HIGHEST_BIT(x) (31u - U32(clz(x)))
#define POPCOUNT64(x) U32(popcount(x))
#define LOWEST_BIT64(x) (63u - U32(clz((x) & (0u - (x)))))
#define GLOBAL_FETCH_ADD(old, target, value) u32 old = atomic_add(&(target), value)
#define GROUP_INDEX U32(get_group_id(0))
#define LANE U32(get_local_id(0))
#define LANE_COUNT U32(WORKGROUP)
#define SHARED_MEMORY __local
#define BARRIER barrier(CLK_LOCAL_MEM_FENCE)
#define ATOMIC_ADD(target, value) atomic_add(&(target), value)
#define ATOMIC_OR(target, value) atomic_or(&(target), value)

#else // C++20, compiled inside a namespace that has defined first_counter (see cmake/kernel_native.cpp.in)
// Builtins instead of <bit>: the linker could keep the copy of a standard inline function that was compiled
// for a newer CPU than the one that runs it.
#define SERIAL
using u32 = std::uint32_t;
using u64 = std::uint64_t;
#define U32(x) static_cast<u32>(x)
#define U64(x) static_cast<u64>(x)
#define FN static inline
FN u32 min(const u32 a, const u32 b) { return a < b ? a : b; }
FN u32 max(const u32 a, const u32 b) { return a < b ? b : a; }
#define PARAMETERS_BEGIN struct Parameters {
#define PARAMETERS_END };
#define KERNEL(name) static inline void name(void *const *const buffers_, const Parameters &p, const u32 UNIT) {
#define CHECK_BINDING(binding) static_assert(binding == __COUNTER__ - first_counter, "bindings go 0, 1, 2, ...");
#define IN(binding, T, name) CHECK_BINDING(binding) const T *__restrict const name = static_cast<const T *>(buffers_[binding]);
#define OUT(binding, T, name) CHECK_BINDING(binding) T *__restrict const name = static_cast<T *>(buffers_[binding]);
#define INOUT(binding, T, name) OUT(binding, T, name)
#define KERNEL_LOCALS
#define KERNEL_BODY
#define KERNEL_END }
#define POPCOUNT(x) U32(__builtin_popcount(x))
#define LOWEST_BIT(x) U32(__builtin_ctz(x))
#define HIGHEST_BIT(x) (31u - U32(__builtin_clz(x)))
#define POPCOUNT64(x) U32(__builtin_popcountll(x))
#define LOWEST_BIT64(x) U32(__builtin_ctzll(x))
#define GLOBAL_FETCH_ADD(old, target, value) const u32 old = __atomic_fetch_add(&(target), value, __ATOMIC_RELAXED)
#endif

#if defined(SERIAL) || defined(ITEM) // one thread serves a work unit
#ifndef SERIAL
#define UNIT (GROUP_INDEX * LANE_COUNT + LANE)
#endif
#define SHARED(T, name, size) T name[size];
#define LANES(i, n) for (u32 i = 0u; i < (n); ++i)
#define ONE_LANE
#define SYNC
#define LOCAL_ADD(target, value) (target) += (value)
#define LOCAL_OR(target, value) (target) |= (value)
#define LOCAL_FETCH_ADD(old, target, value) const u32 old = (target); (target) += (value)
#define SHARED_REDUCTION(T, name)
#define STORE_SUM(target, scratch, value) target = (value)
#else // one workgroup serves a work unit
#define UNIT GROUP_INDEX
#define SHARED(T, name, size) SHARED_MEMORY T name[size];
#define LANES(i, n) for (u32 i = LANE; i < (n); i += LANE_COUNT)
#define ONE_LANE if (LANE == 0u)
#define SYNC BARRIER
#define LOCAL_ADD(target, value) ATOMIC_ADD(target, value)
#define LOCAL_OR(target, value) ATOMIC_OR(target, value)
#define LOCAL_FETCH_ADD(old, target, value) u32 old = ATOMIC_ADD(target, value)
#define SHARED_REDUCTION(T, name) SHARED(T, name, GROUP_LANES)
#define STORE_SUM(target, scratch, value)                                        \
  scratch[LANE] = (value);                                                       \
  SYNC;                                                                          \
  ONE_LANE {                                                                     \
    for (u32 l_ = 1u; l_ < LANE_COUNT; ++l_) scratch[0] += scratch[l_];          \
    target = scratch[0];                                                         \
  }                                                                              \
  SYNC
#endif

// Mesa's llvmpipe silently ends every loop of a work-item once it has taken 65 535 turns altogether. This is
// the last statement of a kernel whose loops depend on data. It counts the units in which that happened.
// p.two is 2.
#ifdef SERIAL
#define COUNT_CUT_LOOPS(counter) (void)(counter)
#else
#define COUNT_CUT_LOOPS(counter)                                                 \
  u32 turns_ = 0u;                                                               \
  for (u32 t_ = 0u; t_ < p.two; ++t_) ++turns_;                                  \
  if (turns_ != p.two) ATOMIC_ADD(counter, 1u)
#endif

#endif // BOXUNION_DIALECT_H

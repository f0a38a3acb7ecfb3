// SPDX-License-Identifier: Apache-2.0
// Four doubles at once, for the inner loops of the finite-element levels, and the better
// instructions of newer processors where there are any.
#pragma once

namespace lcrig {

// The compiler splits it on processors with shorter registers.
using Four [[gnu::vector_size(32), gnu::aligned(8), gnu::may_alias]] = double;

inline Four& four(double* at) {
  return *reinterpret_cast<Four*>(at);
}
inline const Four& four(const double* at) {
  return *reinterpret_cast<const Four*>(at);
}

#if defined(__x86_64__)
template <auto work, class... Arguments>
[[gnu::target("avx2,fma"), gnu::flatten]] auto run_avx2(Arguments... arguments) {
  return work(arguments...);
}
#endif

// Calls a version of `work` that suits the processor: one with AVX2 instructions if it has them.
template <auto work, class... Arguments>
auto run_fast(Arguments... arguments) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (avx2) return run_avx2<work>(arguments...);
#endif
  return work(arguments...);
}

}  // namespace lcrig

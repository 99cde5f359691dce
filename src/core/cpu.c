/* cpu.c: the levels are those of the x86-64 psABI (v2, v3, v4), told apart by the features that
 * define them. */
#include "core/cpu.h"

air_cpu air_cpu_detect(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    const bool v2 = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
    const bool v3 = v2 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    return v4 ? AIR_CPU_AVX512 : v3 ? AIR_CPU_AVX2 : v2 ? AIR_CPU_SSE42 : AIR_CPU_C;
#else
    return AIR_CPU_C;
#endif
}

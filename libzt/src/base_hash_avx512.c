/* SPDX-License-Identifier: Apache-2.0 */
/* The hash for AVX-512. */
#include "base_hash.h"

#if (defined(__x86_64__) || defined(__i386__)) && (defined(__GNUC__) || defined(__clang__))

#ifdef __clang__
#include <immintrin.h>
#include <stdlib.h>
#include <string.h>
#pragma clang attribute push(__attribute__((target("avx2,avx512f"))), apply_to = function)
#else
#pragma GCC target("avx2,avx512f")
#endif
#define XXH_VECTOR XXH_AVX512
#include "base_hash_xxh3.h"
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC reset_options
#endif

const zt__hash_kernel *zt__hash_kernel_avx512(void) {
    static const zt__hash_kernel kernel = {hash, begin, more, end};
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("avx512f") ? &kernel : NULL;
}

#else

const zt__hash_kernel *zt__hash_kernel_avx512(void) {
    return NULL;
}

#endif

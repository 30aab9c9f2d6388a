/* SPDX-License-Identifier: Apache-2.0 */
/* The hash for AVX2: twice as fast as the usual one. */
#include "base_hash.h"

#if (defined(__x86_64__) || defined(__i386__)) && (defined(__GNUC__) || defined(__clang__))

#ifdef __clang__
#include <immintrin.h>
#include <stdlib.h>
#include <string.h>
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif
#define XXH_VECTOR XXH_AVX2
#include "base_hash_xxh3.h"
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC reset_options
#endif

const zt__hash_kernel *zt__hash_kernel_avx2(void) {
    static const zt__hash_kernel kernel = {hash, begin, more, end};
    return __builtin_cpu_supports("avx2") ? &kernel : NULL;
}

#else

const zt__hash_kernel *zt__hash_kernel_avx2(void) {
    return NULL;
}

#endif

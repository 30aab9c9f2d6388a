/* SPDX-License-Identifier: Apache-2.0 */
/* What the test programs share: CHECK prints where it failed and counts; random numbers come from a seed. */
#ifndef ZT_TEST_H
#define ZT_TEST_H

#include <stdint.h>
#include <stdio.h>

static int test_failures;

/* Goes on behind a failure, so that one run shows all; prints the first thirty. */
#define CHECK(condition)                                                            \
    do {                                                                            \
        if (!(condition) && test_failures++ < 30)                                   \
            fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
    } while (0)

/* The end of main. */
static inline int test_end(void) {
    if (test_failures != 0)
        fprintf(stderr, "%d checks failed\n", test_failures);
    return test_failures != 0;
}

/* xorshift64* (Vigna 2016). The state is not zero. */
static inline uint64_t test_random(uint64_t *state) {
    uint64_t x = *state;
    x ^= x >> 12;
    x ^= x << 25;
    x ^= x >> 27;
    *state = x;
    return x * UINT64_C(2685821657736338717);
}

/* 0 <= result < count */
static inline uint32_t test_below(uint64_t *state, uint32_t count) {
    return (uint32_t)((test_random(state) >> 32) * count >> 32);
}

/* Uniform in [low, high). */
static inline double test_uniform(uint64_t *state, double low, double high) {
    return low + (high - low) * ((double)(test_random(state) >> 11) * 0x1p-53);
}

#endif

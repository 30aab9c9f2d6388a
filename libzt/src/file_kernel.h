/* SPDX-License-Identifier: Apache-2.0 */
/* Filter kernels of the mip levels: which source texels an output texel is made of along one axis, and with which
 * weights. */
#ifndef ZT_FILE_KERNEL_H
#define ZT_FILE_KERNEL_H

#include <stdbool.h>
#include <stdint.h>

enum {
    ZT__MAX_TAPS = 24 /* Kaiser reaches 3 output texels to each side, each up to 3 source texels wide */
};

/* n source texels become n2 = max(1, n >> 1). n = 1: passed through. */
typedef struct zt__axis {
    uint32_t n, n2;
    uint8_t filter; /* zt_mip_filter */
    uint8_t wrap;   /* zt_wrap */
    uint32_t taps;  /* of every output, weights of 0 included */
    bool fixed;     /* n is even: all outputs have these weights */
    float weights[ZT__MAX_TAPS];
} zt__axis;

void zt__axis_init(zt__axis *axis, uint32_t n, uint8_t filter, uint8_t wrap);

/* Index of the first source texel of output i, which may lie outside; both may go on beyond the ends: output i + n2
 * begins n later than i. */
int64_t zt__axis_first(const zt__axis *axis, int64_t i);

/* The weights of output i; they add up to 1 but for rounding. */
void zt__axis_weights(const zt__axis *axis, int64_t i, float *weights);

/* The texel that index j means under the wrap mode, or -1: zero. */
int64_t zt__axis_wrap(const zt__axis *axis, int64_t j);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Inside of author_adjust.h: matrices, and looking pictures up. */
#ifndef ZTEX_ADJUST_H
#define ZTEX_ADJUST_H

#include "author_adjust.h"

/* out = a b. out may not be one of them. */
void adjust_multiply(const double a[9], const double b[9], double out[9]);
/* 0, or -1 when there is no inverse. out may not be m. */
int adjust_invert(const double m[9], double out[9]);
/* 0, or -1 behind the horizon. */
int adjust_apply(const double m[9], double x, double y, double out[2]);
/* d out / d (x, y) by rows at a point before the horizon. */
void adjust_jacobian(const double m[9], double x, double y, double out[4]);

/* The picture at (x, y) in texels, the centre of the first one at 0.5, cubic. */
void adjust_sample(const author_picture *picture, double x, double y, float *out);

/* hypot, but with the same result on every machine. */
double adjust_length(double x, double y);

/* Channels without the alpha at the end of two and of four. */
static inline uint32_t adjust_colours(const author_picture *picture) {
    return picture->channels - (picture->channels % 2 == 0);
}

#endif

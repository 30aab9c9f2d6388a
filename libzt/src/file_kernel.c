/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Kernels in + - * / and sqrt of binary64 alone, so that every machine finds the same weights. A weight is the mean of
 * the kernel over the source texel (box: exactly, the others: over eight points), which keeps the phase right when the
 * size is odd.
 */
#include "file_kernel.h"

#include <math.h>
#include <string.h>

#include "zt/zt_write.h"

enum { POINTS = 8 };

/* sin(pi x) / (pi x), |x| <= 3. */
static double sinc(double x) {
    const double pi = 3.14159265358979323846;
    double whole = floor(x + 0.5), r = pi * (x - whole), square = r * r;
    if (x == 0.0)
        return 1.0;
    double term = r, sum = r;
    for (int k = 1; k <= 11; k++) {
        term = -term * square / (double)(2 * k * (2 * k + 1));
        sum += term;
    }
    bool odd = ((int)whole & 1) != 0;
    return (odd ? -sum : sum) / (pi * x);
}

/* Modified Bessel function of the first kind and order 0, 0 <= x <= 4. */
static double bessel0(double x) {
    double quarter = x * x / 4.0, term = 1.0, sum = 1.0;
    for (int k = 1; k <= 16; k++) {
        term = term * quarter / (double)(k * k);
        sum += term;
    }
    return sum;
}

/* But for a constant factor, which normalising takes out. */
static double kaiser(double x) {
    const double reach = 3.0, alpha = 4.0;
    double t = x / reach;
    if (t * t >= 1.0)
        return 0.0;
    return sinc(x) * bessel0(alpha * sqrt(1.0 - t * t));
}

static double mitchell(double x) {
    double t = fabs(x);
    if (t < 1.0)
        return ((7.0 * t - 12.0) * t * t + 16.0 / 3.0) / 6.0;
    if (t < 2.0)
        return (((-7.0 / 3.0 * t + 12.0) * t - 20.0) * t + 32.0 / 3.0) / 6.0;
    return 0.0;
}

static double triangle(double x) {
    double t = fabs(x);
    return t < 1.0 ? 1.0 - t : 0.0;
}

static double kernel(uint8_t filter, double x) {
    switch (filter) {
    case ZT_MIP_KAISER:
        return kaiser(x);
    case ZT_MIP_MITCHELL:
        return mitchell(x);
    default:
        return triangle(x);
    }
}

/* To each side, in output texels. */
static double reach_of(uint8_t filter) {
    switch (filter) {
    case ZT_MIP_KAISER:
        return 3.0;
    case ZT_MIP_MITCHELL:
        return 2.0;
    case ZT_MIP_TRIANGLE:
        return 1.0;
    default:
        return 0.5;
    }
}

static double scale_of(const zt__axis *axis) {
    return (double)axis->n / (double)axis->n2;
}

static double centre_of(const zt__axis *axis, int64_t i) {
    return ((double)i + 0.5) * scale_of(axis);
}

/* Mean of the kernel over source texel j. */
static double texel_weight(const zt__axis *axis, double centre, int64_t j) {
    double scale = scale_of(axis), left = (double)j, sum = 0.0;
    if (axis->filter == ZT_MIP_BOX) {
        double from = centre - 0.5 * scale, to = centre + 0.5 * scale;
        from = from > left ? from : left;
        to = to < left + 1.0 ? to : left + 1.0;
        return to > from ? to - from : 0.0;
    }
    for (int k = 0; k < POINTS; k++)
        sum += kernel(axis->filter, (left + ((double)k + 0.5) / POINTS - centre) / scale);
    return sum;
}

/* Output i of 0 ... n2 - 1. */
static int64_t first_inside(const zt__axis *axis, int64_t i) {
    if (axis->n == 1)
        return 0;
    return (int64_t)floor(centre_of(axis, i) - reach_of(axis->filter) * scale_of(axis));
}

static void make_weights(const zt__axis *axis, int64_t i, float *weights) {
    double w[ZT__MAX_TAPS], sum = 0.0, centre = centre_of(axis, i);
    int64_t first = first_inside(axis, i);
    for (uint32_t t = 0; t < axis->taps; t++) {
        w[t] = axis->n == 1 ? 1.0 : texel_weight(axis, centre, first + (int64_t)t);
        sum += w[t];
    }
    for (uint32_t t = 0; t < axis->taps; t++)
        weights[t] = (float)(w[t] / sum);
}

void zt__axis_init(zt__axis *axis, uint32_t n, uint8_t filter, uint8_t wrap) {
    memset(axis, 0, sizeof *axis);
    axis->n = n;
    axis->n2 = n > 1 ? n / 2 : 1;
    axis->filter = filter;
    axis->wrap = wrap;
    axis->fixed = n == 1 || n % 2 == 0;
    double width = 2.0 * reach_of(filter) * scale_of(axis);
    axis->taps = n == 1 ? 1 : (uint32_t)ceil(width) + (axis->fixed ? 0U : 1U);
    if (axis->fixed)
        make_weights(axis, 0, axis->weights);
}

int64_t zt__axis_first(const zt__axis *axis, int64_t i) {
    int64_t turns = i / axis->n2;
    return first_inside(axis, i % axis->n2) + turns * (int64_t)axis->n;
}

void zt__axis_weights(const zt__axis *axis, int64_t i, float *weights) {
    if (axis->fixed)
        memcpy(weights, axis->weights, axis->taps * sizeof *weights);
    else
        make_weights(axis, i % axis->n2, weights);
}

int64_t zt__axis_wrap(const zt__axis *axis, int64_t j) {
    int64_t n = axis->n, m;
    if (j >= 0 && j < n)
        return j;
    switch (axis->wrap) {
    case ZT_WRAP_REPEAT:
        m = j % n;
        return m < 0 ? m + n : m;
    case ZT_WRAP_MIRROR:
        m = j % (2 * n);
        m = m < 0 ? m + 2 * n : m;
        return m < n ? m : 2 * n - 1 - m;
    case ZT_WRAP_CLAMP:
        return j < 0 ? 0 : n - 1;
    default:
        return -1;
    }
}

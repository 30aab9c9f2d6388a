/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Transfer characteristics (spec/registry.md, CICP) and back. Powers are computed here from additions, multiplications
 * and divisions of binary64 alone, because the powers of C libraries differ in their last bits, and mip levels, hence
 * files, must not depend on the machine.
 */
#include <float.h>
#include <math.h>

#include "base_bytes.h"
#include "file_format.h"

/* log2 of a positive normal number: x = 2^e m with m in [sqrt(1/2), sqrt(2)), and ln m = 2 artanh s with
 * s = (m - 1) / (m + 1), |s| < 0.1716: nine terms of its series leave less than 1e-15. */
static double log2_of(double x) {
    uint64_t bits = zt__bits_of_double(x);
    int32_t exponent = (int32_t)(bits >> 52) - 1023;
    double m = zt__double_of_bits((bits & UINT64_C(0xFFFFFFFFFFFFF)) | UINT64_C(1023) << 52);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        exponent++;
    }
    double s = (m - 1.0) / (m + 1.0);
    double z = s * s;
    double sum = 1.0 / 17.0;
    sum = sum * z + 1.0 / 15.0;
    sum = sum * z + 1.0 / 13.0;
    sum = sum * z + 1.0 / 11.0;
    sum = sum * z + 1.0 / 9.0;
    sum = sum * z + 1.0 / 7.0;
    sum = sum * z + 1.0 / 5.0;
    sum = sum * z + 1.0 / 3.0;
    sum = sum * z + 1.0;
    return (double)exponent + sum * s * 2.8853900817779268; /* 2 / ln 2 */
}

/* 2^y for |y| <= 1000: y = n + f with |f| <= 1/2, and e^(f ln 2) to the twelfth power leaves less than 1e-15. */
static double exp2_of(double y) {
    int32_t n = (int32_t)(y < 0.0 ? y - 0.5 : y + 0.5);
    double x = (y - (double)n) * 0.69314718055994531;
    double sum = 1.0 / 479001600.0;
    sum = sum * x + 1.0 / 39916800.0;
    sum = sum * x + 1.0 / 3628800.0;
    sum = sum * x + 1.0 / 362880.0;
    sum = sum * x + 1.0 / 40320.0;
    sum = sum * x + 1.0 / 5040.0;
    sum = sum * x + 1.0 / 720.0;
    sum = sum * x + 1.0 / 120.0;
    sum = sum * x + 1.0 / 24.0;
    sum = sum * x + 1.0 / 6.0;
    sum = sum * x + 1.0 / 2.0;
    sum = sum * x + 1.0;
    sum = sum * x + 1.0;
    return sum * zt__double_of_bits((uint64_t)(1023 + n) << 52);
}

double zt__power(double x, double p) {
    if (!(x >= DBL_MIN)) /* also zero; nothing here is so small but it */
        return 0.0;
    if (x > DBL_MAX)
        return x;
    double y = log2_of(x) * p;
    if (y < -1000.0)
        return 0.0;
    return exp2_of(y > 1000.0 ? 1000.0 : y);
}

/* ITU-R BT.709 and kin with the unrounded constants of ITU-T H.273, which make both pieces meet. */
static const double bt709_alpha = 1.099296826809442;
static const double bt709_beta = 0.018053968510807;

/* SMPTE ST 2084. */
static const double pq_m1 = 2610.0 / 16384.0;
static const double pq_m2 = 2523.0 / 4096.0 * 128.0;
static const double pq_c1 = 3424.0 / 4096.0;
static const double pq_c2 = 2413.0 / 4096.0 * 32.0;
static const double pq_c3 = 2392.0 / 4096.0 * 32.0;

static double pq_decode(double v) {
    if (v > 1.0) /* the curve ends at 10,000 cd/m^2 and has a pole behind */
        return 1.0;
    double e = zt__power(v, 1.0 / pq_m2);
    return e > pq_c1 ? zt__power((e - pq_c1) / (pq_c2 - pq_c3 * e), 1.0 / pq_m1) : 0.0;
}

static double pq_encode(double l) {
    double y = zt__power(l > 1.0 ? 1.0 : l, pq_m1);
    double v = zt__power((pq_c1 + pq_c2 * y) / (1.0 + pq_c3 * y), pq_m2);
    return l > 0.0 ? v : 0.0;
}

/* v >= 0 */
static double decode(uint32_t transfer, double v) {
    switch (transfer) {
    case 1:
    case 6:
    case 14:
    case 15:
        return v < 4.5 * bt709_beta ? v / 4.5 : zt__power((v + (bt709_alpha - 1.0)) / bt709_alpha, 1.0 / 0.45);
    case 4:
        return zt__power(v, 2.2);
    case 5:
        return zt__power(v, 2.8);
    case ZT_TRANSFER_SRGB:
        return v <= 0.04045 ? v / 12.92 : zt__power((v + 0.055) / 1.055, 2.4);
    case ZT_TRANSFER_PQ:
        return pq_decode(v);
    default:
        return v;
    }
}

/* l >= 0 */
static double encode(uint32_t transfer, double l) {
    switch (transfer) {
    case 1:
    case 6:
    case 14:
    case 15:
        return l < bt709_beta ? l * 4.5 : bt709_alpha * zt__power(l, 0.45) - (bt709_alpha - 1.0);
    case 4:
        return zt__power(l, 1.0 / 2.2);
    case 5:
        return zt__power(l, 1.0 / 2.8);
    case ZT_TRANSFER_SRGB:
        return l <= 0.04045 / 12.92 ? l * 12.92 : 1.055 * zt__power(l, 1.0 / 2.4) - 0.055;
    case ZT_TRANSFER_PQ:
        return pq_encode(l);
    default:
        return l;
    }
}

/* Conversion of a double beyond float's range is undefined in C. */
static float to_float(double v) {
    return v > FLT_MAX ? INFINITY : (float)v;
}

int zt_transfer_known(uint32_t transfer) {
    switch (transfer) {
    case 1:
    case ZT_TRANSFER_UNSPECIFIED:
    case 4:
    case 5:
    case 6:
    case ZT_TRANSFER_LINEAR:
    case ZT_TRANSFER_SRGB:
    case 14:
    case 15:
    case ZT_TRANSFER_PQ:
        return 1;
    default:
        return 0;
    }
}

float zt_transfer_decode(uint32_t transfer, float value) {
    if (value != value || zt__transfer_is_identity(transfer))
        return value;
    float result = to_float(decode(transfer, value < 0.0f ? -(double)value : (double)value));
    return value < 0.0f ? -result : result;
}

float zt_transfer_encode(uint32_t transfer, float value) {
    if (value != value || zt__transfer_is_identity(transfer))
        return value;
    float result = to_float(encode(transfer, value < 0.0f ? -(double)value : (double)value));
    return value < 0.0f ? -result : result;
}

void zt__linearise(uint32_t transfer, float *rgba, size_t count) {
    if (zt__transfer_is_identity(transfer))
        return;
    for (size_t i = 0; i < count; i++, rgba += 4) {
        for (int c = 0; c < 3; c++)
            rgba[c] = zt_transfer_decode(transfer, rgba[c]);
    }
}

void zt__delinearise(uint32_t transfer, float *rgba, size_t count) {
    if (zt__transfer_is_identity(transfer))
        return;
    for (size_t i = 0; i < count; i++, rgba += 4) {
        for (int c = 0; c < 3; c++)
            rgba[c] = zt_transfer_encode(transfer, rgba[c]);
    }
}

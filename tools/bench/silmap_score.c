/* SPDX-License-Identifier: Apache-2.0 */
/* How far a picture is from the truth, as displayed: PSNR and SSIM (Wang et al. 2004: Gaussian window of 1.5
 * pixels). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "silmap_bench.h"

enum { REACH = 5, CURVE = 8192 };

static const double sigma = 1.5, c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;

static void code(const float *linear, size_t count, uint32_t channels, uint32_t channel, float *out) {
    static float curve[CURVE + 1];
    if (curve[CURVE] == 0)
        for (int i = 0; i <= CURVE; i++)
            curve[i] = zt_transfer_encode(ZT_TRANSFER_SRGB, (float)i / CURVE * ((float)i / CURVE));
    for (size_t i = 0; i < count; i++)
        out[i] = curve[(int)(sqrtf(fminf(fmaxf(linear[i * channels + channel], 0), 1)) * CURVE + 0.5F)];
}

/* Along the row, the window cut off at its ends. */
static float blurred(const float *row, size_t at, size_t n, const double weights[REACH + 1]) {
    double sum = 0, weight = 0;
    size_t first = at < REACH ? 0 : at - REACH, end = at + REACH + 1 < n ? at + REACH + 1 : n;
    for (size_t x = first; x < end; x++) {
        double w = weights[x < at ? at - x : x - at];
        sum += w * (double)row[x];
        weight += w;
    }
    return (float)(sum / weight);
}

static void blur(float *values, float *other, size_t n) {
    double weights[REACH + 1];
    for (int i = 0; i <= REACH; i++)
        weights[i] = exp(-i * i / (2 * sigma * sigma));
    for (int pass = 0; pass < 2; pass++) { /* each one along the rows, then turned */
        for (size_t i = 0; i < n * n; i++)
            other[i % n * n + i / n] = blurred(values + i / n * n, i % n, n, weights);
        memcpy(values, other, n * n * sizeof *values);
    }
}

static double similarity(const float *a, const float *b, size_t n) {
    float *maps[5], *other = bench_alloc(n * n, sizeof *other);
    double sum = 0;
    for (int k = 0; k < 5; k++)
        maps[k] = bench_alloc(n * n, sizeof *maps[k]);
    for (size_t i = 0; i < n * n; i++) {
        float values[5] = {a[i], b[i], a[i] * a[i], b[i] * b[i], a[i] * b[i]};
        for (int k = 0; k < 5; k++)
            maps[k][i] = values[k];
    }
    for (int k = 0; k < 5; k++)
        blur(maps[k], other, n);
    for (size_t i = 0; i < n * n; i++) {
        double ma = (double)maps[0][i], mb = (double)maps[1][i];
        double va = (double)maps[2][i] - ma * ma, vb = (double)maps[3][i] - mb * mb, vab = (double)maps[4][i] - ma * mb;
        sum += (2 * ma * mb + c1) * (2 * vab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
    }
    for (int k = 0; k < 5; k++)
        free(maps[k]);
    free(other);
    return sum / (double)(n * n);
}

void score_add(score *s, const float *shown, const float *wanted, const window *w, uint32_t channels) {
    size_t count = w->pixels * w->pixels;
    float *a = bench_alloc(count, sizeof *a), *b = bench_alloc(count, sizeof *b);
    for (uint32_t channel = 0; channel < channels; channel++) {
        code(shown, count, channels, channel, a);
        code(wanted, count, channels, channel, b);
        for (size_t i = 0; i < count; i++)
            s->squares += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
        s->values += (double)count;
        s->ssim += similarity(a, b, w->pixels);
        s->windows++;
    }
    free(a);
    free(b);
}

double score_psnr(const score *s) {
    return s->squares > 0 ? fmin(-10 * log10(s->squares / s->values), 99) : 99;
}

double score_ssim(const score *s) {
    return s->windows > 0 ? s->ssim / s->windows : 1;
}

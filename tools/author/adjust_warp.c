/* SPDX-License-Identifier: Apache-2.0 */
/* Resampling a picture through a homography. */
#include "adjust.h"
#include "zipmap_private.h"

#include <math.h>
#include <string.h>

#define MOST_CHANNELS 4
#define MOST_PROBES 16 /* a side, for one texel */

void adjust_multiply(const double a[9], const double b[9], double out[9]) {
    plane left, right;
    memcpy(left.m, a, sizeof left.m);
    memcpy(right.m, b, sizeof right.m);
    plane product = plane_multiply(&left, &right);
    memcpy(out, product.m, sizeof product.m);
}

int adjust_invert(const double m[9], double out[9]) {
    plane from, back;
    memcpy(from.m, m, sizeof from.m);
    int done = plane_inverse(&from, &back);
    memcpy(out, back.m, sizeof back.m);
    return done ? 0 : -1;
}

int adjust_apply(const double m[9], double x, double y, double out[2]) {
    double w = m[6] * x + m[7] * y + m[8];
    if (!(w > 0.0))
        return -1;
    out[0] = (m[0] * x + m[1] * y + m[2]) / w;
    out[1] = (m[3] * x + m[4] * y + m[5]) / w;
    return isfinite(out[0]) && isfinite(out[1]) ? 0 : -1;
}

void adjust_jacobian(const double m[9], double x, double y, double out[4]) {
    double w = m[6] * x + m[7] * y + m[8];
    double u = (m[0] * x + m[1] * y + m[2]) / w, v = (m[3] * x + m[4] * y + m[5]) / w;
    out[0] = (m[0] - u * m[6]) / w;
    out[1] = (m[1] - u * m[7]) / w;
    out[2] = (m[3] - v * m[6]) / w;
    out[3] = (m[4] - v * m[7]) / w;
}

double adjust_length(double x, double y) {
    return sqrt(x * x + y * y);
}

/* ---- one lookup ------------------------------------------------------------------------------------------- */

static uint32_t held(int64_t i, uint32_t size) {
    return i < 0 ? 0 : i >= (int64_t)size ? size - 1 : (uint32_t)i;
}

/* Catmull-Rom (Keys 1981, a = -1/2). */
static void cubic(float t, float w[4]) {
    w[0] = ((2.0f - t) * t - 1.0f) * t * 0.5f;
    w[1] = ((3.0f * t - 5.0f) * t * t + 2.0f) * 0.5f;
    w[2] = ((4.0f - 3.0f * t) * t + 1.0f) * t * 0.5f;
    w[3] = (t - 1.0f) * t * t * 0.5f;
}

void adjust_sample(const author_picture *picture, double x, double y, float *out) {
    uint32_t channels = picture->channels;
    double limit = 4.0 * ((double)picture->width + picture->height) + 16.0;
    x = fmin(fmax(x - 0.5, -limit), limit);
    y = fmin(fmax(y - 0.5, -limit), limit);
    int64_t left = (int64_t)floor(x), top = (int64_t)floor(y);
    float wx[4], wy[4], sum[MOST_CHANNELS] = {0};
    cubic((float)(x - (double)left), wx);
    cubic((float)(y - (double)top), wy);
    for (int j = 0; j < 4; j++) {
        const float *row = picture->texels + (size_t)held(top + j - 1, picture->height) * picture->width * channels;
        for (int i = 0; i < 4; i++) {
            const float *texel = row + (size_t)held(left + i - 1, picture->width) * channels;
            float weight = wy[j] * wx[i];
            for (uint32_t c = 0; c < channels; c++)
                sum[c] += weight * texel[c];
        }
    }
    memcpy(out, sum, channels * sizeof *out);
}

/* ---- a picture -------------------------------------------------------------------------------------------- */

typedef struct warp {
    const author_picture *from;
    author_picture *out;
    uint8_t *inside;
    double back[9]; /* coordinates of out to those of from */
} warp;

/* Texels of `from` along the longer side of what a texel of `out` shows. */
static uint32_t probes_of(const warp *w, double x, double y) {
    double j[4];
    adjust_jacobian(w->back, x, y, j);
    double fw = w->from->width, fh = w->from->height, ow = w->out->width, oh = w->out->height;
    double along_x = adjust_length(j[0] * fw, j[2] * fh) / ow, along_y = adjust_length(j[1] * fw, j[3] * fh) / oh;
    double most = fmax(along_x, along_y);
    return most > 1.5 ? (uint32_t)fmin(ceil(most), MOST_PROBES) : 1;
}

static void warp_texel(const warp *w, uint32_t x, uint32_t y, float *out) {
    double sx = 1.0 / w->out->width, sy = 1.0 / w->out->height, at[2];
    double cx = (x + 0.5) * sx, cy = (y + 0.5) * sy;
    size_t texel = (size_t)y * w->out->width + x;
    int seen = adjust_apply(w->back, cx, cy, at) == 0;
    int inside = seen && at[0] >= 0.0 && at[0] <= 1.0 && at[1] >= 0.0 && at[1] <= 1.0;
    if (w->inside)
        w->inside[texel] = (uint8_t)inside;
    if (!seen)
        return;
    uint32_t n = probes_of(w, cx, cy), channels = w->from->channels;
    float value[MOST_CHANNELS];
    for (uint32_t p = 0; p < n * n; p++) {
        double px = (x + (p % n + 0.5) / n) * sx, py = (y + (p / n + 0.5) / n) * sy;
        if (adjust_apply(w->back, px, py, at))
            continue;
        adjust_sample(w->from, at[0] * w->from->width, at[1] * w->from->height, value);
        for (uint32_t c = 0; c < channels; c++)
            out[c] += value[c] / (float)(n * n);
    }
}

static author_result warp_row(void *context, size_t y, unsigned worker, char *error) {
    const warp *w = context;
    (void)worker;
    (void)error;
    float *row = w->out->texels + y * w->out->width * w->out->channels;
    for (uint32_t x = 0; x < w->out->width; x++)
        warp_texel(w, x, (uint32_t)y, row + (size_t)x * w->out->channels);
    return AUTHOR_OK;
}

author_result author_warp(author_run *run, const author_picture *from, const double matrix[9], uint32_t width,
                          uint32_t height, author_picture *out, uint8_t *inside) {
    warp w = {.from = from, .out = out, .inside = inside};
    *out = (author_picture){0};
    if (adjust_invert(matrix, w.back))
        return author_fail(run, AUTHOR_BAD_INPUT, "the placement cannot be inverted");
    author_result result = author_picture_create(run, width, height, from->channels, out);
    if (result == AUTHOR_OK)
        result = author_for(run, "warping", height, warp_row, &w);
    if (result != AUTHOR_OK)
        author_picture_release(out);
    return result;
}

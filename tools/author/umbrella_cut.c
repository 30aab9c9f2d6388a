/* SPDX-License-Identifier: Apache-2.0 */
/* The pictures of bases: cut out, reduced, their colours going on where nothing is; and local means of colour. */
#include <math.h>
#include <stdlib.h>

#include "umbrella_private.h"

static void texel_at(const author_picture *p, const author_picture *coverage, int64_t x, int64_t y, float rgba[4]) {
    uint32_t n = p->channels;
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return;
    size_t at = (size_t)y * p->width + (size_t)x;
    const float *texel = p->texels + at * n;
    for (uint32_t c = 0; c < 3; c++)
        rgba[c] = texel[n < 3 ? 0 : c];
    rgba[3] = coverage ? coverage->texels[at] : n == 2 || n == 4 ? texel[n - 1] : 1.0f;
}

static void reduce_texel(const author_picture *picture, const author_picture *coverage, const umb_cut *cut, uint32_t x,
                         uint32_t y, float *out) {
    double sum[4] = {0, 0, 0, 0};
    float rgba[4];
    for (uint32_t i = 0; i < cut->factor * cut->factor; i++) {
        texel_at(picture, coverage, cut->x0 + (int64_t)x * cut->factor + i % cut->factor,
                 cut->y0 + (int64_t)y * cut->factor + i / cut->factor, rgba);
        for (int c = 0; c < 3; c++)
            sum[c] += (double)rgba[c] * (double)rgba[3];
        sum[3] += (double)rgba[3];
    }
    for (int c = 0; c < 3; c++)
        out[c] = sum[3] > 0 ? (float)(sum[c] / sum[3]) : 0.0f;
    out[3] = (float)(sum[3] / (cut->factor * cut->factor));
}

/* What has no alpha takes the colour of the nearest coarser average that has. */
static author_result bleed(author_run *run, author_picture *picture) {
    author_picture half;
    uint32_t w = (picture->width + 1) / 2, h = (picture->height + 1) / 2;
    umb_cut cut = {0, 0, w, h, 2};
    if (picture->width == 1 && picture->height == 1)
        return AUTHOR_OK;
    author_result result = author_picture_create(run, w, h, 4, &half);
    if (result != AUTHOR_OK)
        return result;
    for (uint32_t i = 0; i < w * h; i++)
        reduce_texel(picture, NULL, &cut, i % w, i / w, half.texels + 4 * (size_t)i);
    result = bleed(run, &half);
    for (size_t i = 0; i < (size_t)picture->width * picture->height; i++) {
        float *texel = picture->texels + 4 * i;
        const float *from = half.texels + 4 * (i / picture->width / 2 * w + i % picture->width / 2);
        for (int c = 0; c < 3 && texel[3] == 0.0f; c++)
            texel[c] = from[c];
    }
    author_picture_release(&half);
    return result;
}

author_result umb_cut_out(author_run *run, const author_picture *picture, const author_picture *coverage,
                          const umb_cut *cut, author_picture *out) {
    author_result result = author_picture_create(run, cut->width, cut->height, 4, out);
    if (result != AUTHOR_OK)
        return result;
    for (size_t i = 0; i < (size_t)cut->width * cut->height; i++)
        reduce_texel(picture, coverage, cut, (uint32_t)(i % cut->width), (uint32_t)(i / cut->width),
                     out->texels + 4 * i);
    result = bleed(run, out);
    if (result != AUTHOR_OK)
        author_picture_release(out);
    return result;
}

int umb_local_mean(const author_picture *picture, const author_picture *coverage, author_xy place, double radius,
                   double mean[3]) {
    double weight = 0, sum[3] = {0, 0, 0};
    double r = radius < 1 ? 1 : radius;
    float rgba[4];
    for (int64_t y = (int64_t)floor(place.y - r); y <= (int64_t)floor(place.y + r); y++)
        for (int64_t x = (int64_t)floor(place.x - r); x <= (int64_t)floor(place.x + r); x++) {
            double dx = (double)x + 0.5 - place.x, dy = (double)y + 0.5 - place.y, c, s;
            double far = sqrt(dx * dx + dy * dy) / r;
            if (far >= 1)
                continue;
            umb_turn(far / 2, &c, &s);
            texel_at(picture, coverage, x, y, rgba);
            double w = (1 + c) * (double)rgba[3];
            weight += w;
            for (int i = 0; i < 3; i++)
                sum[i] += w * (double)rgba[i];
        }
    for (int i = 0; i < 3; i++)
        mean[i] = weight > 0 ? sum[i] / weight : 0;
    return weight > 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Two pictures brought to one resolution: the texels of the coarse one, the fine one low-passed to them. */
#include <math.h>
#include <stdlib.h>

#include "zipmap_private.h"

enum { BALANCE_TEXELS = 4000 };

static const double LEAST_ROOT = 0.08; /* of a channel whose balance is measured */
static const double MOST_GAIN = 3;     /* logarithm */

static const double OVERSAMPLING = 2; /* texels of the low-passed fine picture per texel of the coarse one */

bool view_footprint(const plane *matrix, double box[4]) {
    plane back;
    if (!plane_inverse(matrix, &back))
        return false;
    box[0] = box[1] = 1;
    box[2] = box[3] = 0;
    for (int i = 0; i < 4; i++) {
        double x, y;
        if (!plane_apply(&back, i & 1, i >> 1, &x, &y))
            return false;
        box[0] = fmin(box[0], x);
        box[1] = fmin(box[1], y);
        box[2] = fmax(box[2], x);
        box[3] = fmax(box[3], y);
    }
    box[0] = fmax(box[0], 0);
    box[1] = fmax(box[1], 0);
    box[2] = fmin(box[2], 1);
    box[3] = fmin(box[3], 1);
    return box[0] < box[2] && box[1] < box[3];
}

uint32_t view_level(const luma *light, const double box[4], size_t texels) {
    uint32_t l = 0;
    while (l + 1 < light->count &&
           (box[2] - box[0]) * light->level[l].width * (box[3] - box[1]) * light->level[l].height > (double)texels)
        l++;
    return l;
}

void view_release(view *v) {
    free(v->coarse.texels);
    free(v->fine.texels);
    *v = (view){0};
}

static uint32_t reduced(uint32_t size, double factor) {
    double reduced_size = floor(size * factor + 0.5);
    return reduced_size >= size ? size : reduced_size < 4 ? 4 : (uint32_t)reduced_size;
}

author_result view_open(author_run *run, const luma *coarse, const luma *fine, const float weights[2][3], float clipped,
                        uint32_t level, const plane *matrix, view *out) {
    double box[4];
    *out = (view){.size = {coarse->level[level].width, coarse->level[level].height}};
    if (!view_footprint(matrix, box))
        return AUTHOR_OK;
    for (int i = 0; i < 2; i++) {
        out->box[i] = (uint32_t)floor(box[i] * out->size[i]);
        out->box[i + 2] = (uint32_t)ceil(box[i + 2] * out->size[i]);
    }
    uint32_t fine_size[2] = {fine->level[0].width, fine->level[0].height};
    double factor = OVERSAMPLING / fmax(plane_ratio(matrix, out->size, fine_size), 1e-6);
    author_result result = luma_crop(run, coarse, weights[0], clipped, level, out->box, &out->coarse);
    if (result == AUTHOR_OK)
        result = luma_shrink(run, fine, weights[1], clipped, reduced(fine_size[0], factor),
                             reduced(fine_size[1], factor), &out->fine);
    return result;
}

bool view_average(const view *v, const plane *matrix, size_t x, size_t y, float *out) {
    static const double parts[4][2] = {{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}};
    float sum = 0;
    for (int i = 0; i < 4; i++) {
        double px = ((double)(v->box[0] + x) + parts[i][0]) / v->size[0], fx;
        double py = ((double)(v->box[1] + y) + parts[i][1]) / v->size[1], fy;
        if (!plane_apply(matrix, px, py, &fx, &fy))
            return false;
        fx *= v->fine.width;
        fy *= v->fine.height;
        if (!(fx >= 1 && fy >= 1 && fx <= v->fine.width - 1 && fy <= v->fine.height - 1))
            return false;
        sum += luma_sample(&v->fine, fx, fy);
    }
    *out = isnan(sum) ? 0 : sum / 4;
    return !isnan(sum);
}

/* Logarithms of how much lighter coarse is, and how much that is worth; NaN where not both show something. */
static void compare_light(const view *v, const plane *matrix, double *ratios, double *weights) {
    for (size_t i = 0; i < (size_t)v->coarse.width * v->coarse.height; i++) {
        double coarse = (double)v->coarse.texels[i];
        float fine = 0;
        bool both = view_average(v, matrix, i % v->coarse.width, i / v->coarse.width, &fine);
        bool light = both && coarse > LEAST_ROOT && (double)fine > LEAST_ROOT;
        ratios[i] = light ? 2 * log(coarse / (double)fine) : NAN;
        weights[i] = light ? coarse * coarse : 0;
    }
}

/* The mean of ratios, less those of another channel: vignetting is the same in both, and drops out. */
static double mean_ratio(const double *ratios, const double *weights, const double *others, size_t count) {
    double sum = 0, total = 1e-6;
    for (size_t i = 0; i < count; i++) {
        double ratio = ratios[i] - (others ? others[i] : 0);
        if (isnan(ratio))
            continue;
        sum += weights[i] * ratio;
        total += weights[i];
    }
    return sum / total;
}

author_result view_balance(author_run *run, const luma *coarse, const luma *fine, const plane *matrix,
                           float weights[2][3]) {
    static const int channels[3] = {1, 0, 2}; /* green first: the others go by it */
    double box[4], gains[3] = {0, 0, 0}, *green = NULL;
    bool meet = view_footprint(matrix, box);
    author_result result = AUTHOR_OK;
    for (int i = 0; i < 3 && meet && result == AUTHOR_OK; i++) {
        view v;
        int c = channels[i];
        const float one[2][3] = {{c == 0, c == 1, c == 2}, {c == 0, c == 1, c == 2}};
        result = view_open(run, coarse, fine, one, NAN, view_level(coarse, box, BALANCE_TEXELS), matrix, &v);
        size_t count = (size_t)v.coarse.width * v.coarse.height;
        double *ratios = author_alloc(run, count, 2 * sizeof *ratios);
        if (!ratios)
            result = AUTHOR_NO_MEMORY;
        if (result == AUTHOR_OK) {
            compare_light(&v, matrix, ratios, ratios + count);
            gains[c] = mean_ratio(ratios, ratios + count, green, count) + (green ? gains[1] : 0);
        }
        view_release(&v);
        if (green)
            free(ratios);
        else
            green = ratios;
    }
    free(green);
    for (int c = 0; c < 3; c++) {
        weights[0][c] = LUMA_GREY[c];
        weights[1][c] = LUMA_GREY[c] * (float)exp(fmin(fmax(gains[c], -MOST_GAIN), MOST_GAIN));
    }
    return result;
}

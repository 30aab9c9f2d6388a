/* SPDX-License-Identifier: Apache-2.0 */
/* Repeated texture: whether a picture would lie as well somewhere else in its parent. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

enum {
    TEMPLATE_TEXELS = 1000, /* of the fine picture in the frame of the coarse one, at most */
    LEAST_SHIFT = 3,        /* texels from where it lies that are another place */
    COMPARED_TEXELS = 40000
};

static const double LEAST_PEAK = 0.75; /* correlation from which another place is looked at closely */
static const double LEAST_ALIKE =
    0.8; /* correlation there in the end: on plain colour the difference is small, and says nothing */
static const double LEAST_WORSE = 1.25; /* by what factor the difference must be larger there */

/* The fine picture as the coarse one would show it, on one level, and all of that level. */
typedef struct template {
    view v;
    luma_level whole;
    float *texels; /* less their mean; 0 outside */
    uint8_t *inside;
    double squares;
    size_t count;
}
template;

static void template_release(template *t) {
    view_release(&t->v);
    free(t->whole.texels);
    free(t->texels);
    free(t->inside);
    *t = (template){0};
}

static void fill(template *t, const plane *matrix) {
    size_t count = (size_t)t->v.coarse.width * t->v.coarse.height;
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        t->inside[i] = view_average(&t->v, matrix, i % t->v.coarse.width, i / t->v.coarse.width, &t->texels[i]);
        sum += t->inside[i] ? (double)t->texels[i] : 0;
        t->count += t->inside[i];
    }
    for (size_t i = 0; i < count; i++) {
        t->texels[i] = t->inside[i] ? t->texels[i] - (float)(sum / (double)t->count) : 0;
        t->squares += (double)(t->texels[i] * t->texels[i]);
    }
}

static author_result template_open(author_run *run, const luma *coarse, const luma *fine, const plane *matrix,
                                   template *out) {
    double box[4];
    const float grey[2][3] = {{LUMA_GREY[0], LUMA_GREY[1], LUMA_GREY[2]}, {LUMA_GREY[0], LUMA_GREY[1], LUMA_GREY[2]}};
    *out = (template){0};
    if (!view_footprint(matrix, box))
        return AUTHOR_OK;
    uint32_t level = view_level(coarse, box, TEMPLATE_TEXELS);
    author_result result = view_open(run, coarse, fine, grey, 1, level, matrix, &out->v);
    uint32_t all[4] = {0, 0, coarse->level[level].width, coarse->level[level].height};
    if (result == AUTHOR_OK)
        result = luma_crop(run, coarse, LUMA_GREY, 1, level, all, &out->whole);
    size_t count = (size_t)out->v.coarse.width * out->v.coarse.height;
    out->texels = author_alloc(run, count, sizeof *out->texels);
    out->inside = author_alloc(run, count, 1);
    if (result == AUTHOR_OK && (!out->texels || !out->inside))
        result = AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK)
        fill(out, matrix);
    return result;
}

/* Correlation with the left upper corner of the template's box at (x, y). */
static double correlation_at(const template *t, uint32_t x, uint32_t y) {
    float sum = 0, squares = 0, product = 0;
    for (uint32_t r = 0; r < t->v.coarse.height; r++) {
        const float *line = t->whole.texels + (size_t)(y + r) * t->whole.width + x;
        const float *own = t->texels + (size_t)r * t->v.coarse.width;
        const uint8_t *inside = t->inside + (size_t)r * t->v.coarse.width;
        for (uint32_t c = 0; c < t->v.coarse.width; c++) {
            float value = inside[c] ? line[c] : 0;
            sum += value;
            squares += value * value;
            product += value * own[c];
        }
    }
    double spread = (double)squares - (double)sum * (double)sum / (double)t->count;
    return spread > 1e-9 && t->squares > 0 ? (double)product / sqrt(spread * t->squares) : 0;
}

/* The best place that is not about the template's own. */
static double other_peak(const template *t, uint32_t place[2]) {
    double best = -1;
    for (uint32_t y = 0; y + t->v.coarse.height <= t->whole.height; y++)
        for (uint32_t x = 0; x + t->v.coarse.width <= t->whole.width; x++) {
            int64_t dx = (int64_t)x - t->v.box[0], dy = (int64_t)y - t->v.box[1];
            double value = dx * dx + dy * dy > LEAST_SHIFT * LEAST_SHIFT ? correlation_at(t, x, y) : -1;
            if (value <= best)
                continue;
            best = value;
            place[0] = x;
            place[1] = y;
        }
    return best;
}

/* How far the fine picture's centre is from another place's, in widths of its footprint. */
static double apart(const plane *a, const plane *b) {
    plane back;
    double x, y, u, v;
    if (!plane_inverse(b, &back) || !plane_apply(&back, 0.5, 0.5, &x, &y) || !plane_apply(a, x, y, &u, &v))
        return HUGE_VAL;
    return hypot(u - 0.5, v - 0.5);
}

static author_result compare(author_run *run, const photo *photos, const plane *other, edge *e) {
    refine_result here, there;
    const photo *coarse = &photos[e->coarse], *fine = &photos[e->fine];
    author_result result = refine_plane(run, coarse, fine, &e->matrix, COMPARED_TEXELS, &here);
    if (result == AUTHOR_OK)
        result = refine_plane(run, coarse, fine, other, COMPARED_TEXELS, &there);
    if (result == AUTHOR_OK && here.converged && there.converged && apart(&here.matrix, &there.matrix) > 0.02 &&
        there.correlation > LEAST_ALIKE && there.error < LEAST_WORSE * here.error &&
        plane_plausible(&there.matrix, coarse->pixels, fine->pixels))
        e->reason = AUTHOR_REASON_AMBIGUOUS;
    return result;
}

author_result pair_unique(author_run *run, const photo *photos, edge *e) {
    template t;
    uint32_t place[2] = {0, 0};
    author_result result = template_open(run, &photos[e->coarse].light, &photos[e->fine].light, &e->matrix, &t);
    double peak = result == AUTHOR_OK && t.count ? other_peak(&t, place) : -1;
    if (peak > LEAST_PEAK) {
        double dx = ((double)place[0] - t.v.box[0]) / t.whole.width,
               dy = ((double)place[1] - t.v.box[1]) / t.whole.height;
        plane shift = {{1, 0, -dx, 0, 1, -dy, 0, 0, 1}}, other = plane_multiply(&e->matrix, &shift);
        result = compare(run, photos, &other, e);
    }
    template_release(&t);
    return result;
}

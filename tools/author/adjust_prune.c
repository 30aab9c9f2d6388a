/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Detail that lies so deep beneath opaque patches that no level of detail shows it is replaced by what the picture
 * looks like from further away. Why the depth is what it is: docs/design.md.
 */
#include "adjust.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define OPAQUE (254.75f / 255.0f) /* stored as full coverage, whatever the format */
#define MOST_LEVELS 16

void author_depth_release(author_depth *depth) {
    free(depth->texels);
    *depth = (author_depth){0};
}

author_result author_depth_create(author_run *run, uint32_t width, uint32_t height, author_depth *out) {
    *out = (author_depth){.width = width, .height = height};
    out->texels = author_alloc(run, width, (size_t)height * sizeof *out->texels);
    return out->texels ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* ---- depth -------------------------------------------------------------------------------------------------- */

/* A rectangle of the picture around the patch. */
typedef struct cover {
    const author_depth *depth;
    const author_picture *coverage;
    const double *matrix;
    double back[9];
    uint32_t x, y, width, height;
    uint32_t *steps; /* of the rectangle. 0: shows; then the distance to such a texel */
} cover;

/* 0 when the patch lies beside the picture. */
static int find_rectangle(cover *c) {
    double low[2] = {0.0, 0.0}, high[2] = {c->depth->width, c->depth->height}, at[2];
    for (int i = 0; i < 4; i++) {
        if (adjust_apply(c->back, i & 1, i >> 1, at)) {
            low[0] = low[1] = 0.0;
            high[0] = c->depth->width;
            high[1] = c->depth->height;
            break;
        }
        for (int k = 0; k < 2; k++) {
            double texel = at[k] * (k ? c->depth->height : c->depth->width);
            low[k] = i == 0 ? texel : fmin(low[k], texel);
            high[k] = i == 0 ? texel : fmax(high[k], texel);
        }
    }
    double x0 = fmax(floor(low[0]), 0.0), x1 = fmin(ceil(high[0]), c->depth->width);
    double y0 = fmax(floor(low[1]), 0.0), y1 = fmin(ceil(high[1]), c->depth->height);
    if (!(x0 < x1 && y0 < y1))
        return 0;
    c->x = (uint32_t)x0;
    c->y = (uint32_t)y0;
    c->width = (uint32_t)x1 - c->x;
    c->height = (uint32_t)y1 - c->y;
    return 1;
}

/* Texels of the picture that the patch does not reach. */
static author_result leave_outside(void *context, size_t y, unsigned worker, char *error) {
    const cover *c = context;
    (void)worker;
    (void)error;
    for (uint32_t x = 0; x < c->width; x++) {
        double at[2], px = (c->x + x + 0.5) / c->depth->width, py = (c->y + (double)y + 0.5) / c->depth->height;
        int seen = adjust_apply(c->matrix, px, py, at) == 0;
        int inside = seen && at[0] > 0.0 && at[0] < 1.0 && at[1] > 0.0 && at[1] < 1.0;
        c->steps[y * c->width + x] = inside ? UINT32_MAX : 0;
    }
    return AUTHOR_OK;
}

static void open_hole(const cover *c, double px, double py) {
    double at[2];
    if (adjust_apply(c->back, px, py, at))
        return;
    double x = floor(at[0] * c->depth->width) - c->x, y = floor(at[1] * c->depth->height) - c->y;
    if (x >= 0.0 && y >= 0.0 && x < c->width && y < c->height)
        c->steps[(size_t)y * c->width + (size_t)x] = 0;
}

/* Texels of the picture beneath texels of the patch that are not opaque: every one of the patch's is looked at, because
 * it is finer and may have small holes. The corners of a texel as well as its centre, for patches that are coarser. */
static void open_holes(const cover *c) {
    uint32_t w = c->coverage->width, h = c->coverage->height;
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++) {
            if (c->coverage->texels[(size_t)y * w + x] >= OPAQUE)
                continue;
            open_hole(c, (x + 0.5) / w, (y + 0.5) / h);
            for (uint32_t k = 0; k < 4; k++)
                open_hole(c, (double)(x + k % 2) / w, (double)(y + k / 2) / h);
        }
}

static uint32_t one_more(uint32_t a, uint32_t b) {
    return b < a ? b + 1 < a ? b + 1 : a : a;
}

/* Steps of a king on a chessboard, never more than the distance. Beyond the rectangle everything shows. */
static void measure_depth(const cover *c) {
    uint32_t w = c->width, h = c->height, *s = c->steps;
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++) {
            uint32_t *at = &s[(size_t)y * w + x];
            if (x == 0 || y == 0 || x + 1 == w || y + 1 == h) {
                *at = 0;
                continue;
            }
            const uint32_t *above = at - w;
            *at = one_more(one_more(one_more(one_more(*at, at[-1]), above[0]), above[-1]), above[1]);
        }
    for (uint32_t y = h - 1; y-- > 1;)
        for (uint32_t x = w - 1; x-- > 1;) {
            uint32_t *at = &s[(size_t)y * w + x];
            const uint32_t *below = at + w;
            *at = one_more(one_more(one_more(one_more(*at, at[1]), below[0]), below[-1]), below[1]);
        }
}

/* The longer over the shorter axis of what the patch makes of a circle: levels go by the longer one. */
static double stretch(const cover *c) {
    static const double places[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};
    double most = 1.0;
    for (int i = 0; i < 5; i++) {
        double at[2], j[4];
        if (adjust_apply(c->back, places[i][0], places[i][1], at))
            continue;
        adjust_jacobian(c->matrix, at[0], at[1], j);
        for (int k = 0; k < 4; k++)
            j[k] *= (double)(k < 2 ? c->coverage->width : c->coverage->height) /
                    (double)(k % 2 ? c->depth->height : c->depth->width);
        double sum = j[0] * j[0] + j[1] * j[1] + j[2] * j[2] + j[3] * j[3];
        double area = fabs(j[0] * j[3] - j[1] * j[2]);
        most = fmax(most, (sum + sqrt(fmax(sum * sum - 4.0 * area * area, 0.0))) / (2.0 * area));
    }
    return isfinite(most) ? most : 1e9;
}

static void take_deeper(const cover *c, double less) {
    for (uint32_t y = 0; y < c->height; y++) {
        uint32_t *row = c->depth->texels + (size_t)(c->y + y) * c->depth->width + c->x;
        for (uint32_t x = 0; x < c->width; x++) {
            uint32_t steps = (uint32_t)(c->steps[(size_t)y * c->width + x] * less);
            row[x] = steps > row[x] ? steps : row[x];
        }
    }
}

author_result author_depth_cover(author_run *run, author_depth *depth, const author_picture *coverage,
                                 const double matrix[9]) {
    cover c = {.depth = depth, .coverage = coverage, .matrix = matrix};
    if (adjust_invert(matrix, c.back))
        return author_fail(run, AUTHOR_BAD_INPUT, "the placement cannot be inverted");
    if (!find_rectangle(&c))
        return AUTHOR_OK;
    c.steps = author_alloc(run, c.width, (size_t)c.height * sizeof *c.steps);
    if (!c.steps)
        return AUTHOR_NO_MEMORY;
    author_result result = author_for(run, "pruning", c.height, leave_outside, &c);
    if (result == AUTHOR_OK) {
        open_holes(&c);
        measure_depth(&c);
        take_deeper(&c, 1.0 / stretch(&c));
    }
    free(c.steps);
    return result;
}

/* ---- pruning ------------------------------------------------------------------------------------------------- */

typedef struct prune {
    author_picture *picture;
    const author_depth *depth;
    author_picture levels[MOST_LEVELS]; /* halves, the first one being half the picture */
    int level_count;
    int at; /* the level that is made */
} prune;

/* Box filter of two by two; odd sizes leave their last line to the one before. */
static author_result halve_row(void *context, size_t y, unsigned worker, char *error) {
    const prune *p = context;
    const author_picture *from = p->at > 0 ? &p->levels[p->at - 1] : p->picture;
    const author_picture *to = &p->levels[p->at];
    uint32_t channels = from->channels;
    (void)worker;
    (void)error;
    uint32_t y0 = (uint32_t)(2 * y), y1 = y0 + 1 < from->height ? y0 + 1 : y0;
    for (uint32_t x = 0; x < to->width; x++) {
        uint32_t x0 = 2 * x, x1 = x0 + 1 < from->width ? x0 + 1 : x0;
        for (uint32_t c = 0; c < channels; c++) {
            float sum = from->texels[((size_t)y0 * from->width + x0) * channels + c] +
                        from->texels[((size_t)y0 * from->width + x1) * channels + c] +
                        from->texels[((size_t)y1 * from->width + x0) * channels + c] +
                        from->texels[((size_t)y1 * from->width + x1) * channels + c];
            to->texels[((size_t)y * to->width + x) * channels + c] = 0.25f * sum;
        }
    }
    return AUTHOR_OK;
}

/* The picture as its level shows it, between texels' centres straight on. */
static void look_at(const author_picture *level, double scale, uint32_t x, uint32_t y, float *out) {
    adjust_sample(level, (x + 0.5) * scale, (y + 0.5) * scale, out);
}

/* Detail of which levels may go at this depth: 0, none, up to what is there; the fraction blends two. */
static float levels_to_drop(const prune *p, uint32_t depth) {
    float drop = 0.0f, margin = AUTHOR_PRUNE_MARGIN;
    if ((float)depth < margin)
        return 0.0f;
    while ((float)depth >= 2.0f * margin && drop < (float)p->level_count) {
        margin *= 2.0f;
        drop += 1.0f;
    }
    drop += fminf((float)depth / margin - 1.0f, 1.0f);
    return fminf(drop, (float)p->level_count);
}

static author_result prune_row(void *context, size_t y, unsigned worker, char *error) {
    const prune *p = context;
    author_picture *picture = p->picture;
    uint32_t channels = picture->channels, colours = adjust_colours(picture);
    (void)worker;
    (void)error;
    for (uint32_t x = 0; x < picture->width; x++) {
        float drop = levels_to_drop(p, p->depth->texels[y * picture->width + x]);
        float *texel = picture->texels + (y * picture->width + x) * channels;
        float low[4], high[4];
        if (!(drop > 0.0f))
            continue;
        int level = (int)ceilf(drop) - 1; /* of the blurred ones: it alone has no finer detail */
        float share = drop - (float)level;
        look_at(&p->levels[level], 0.5 / (double)(1 << level), x, (uint32_t)y, high);
        if (level > 0)
            look_at(&p->levels[level - 1], 1.0 / (double)(1 << level), x, (uint32_t)y, low);
        else
            memcpy(low, texel, channels * sizeof *low);
        for (uint32_t c = 0; c < colours; c++)
            texel[c] = fmaxf(low[c] + share * (high[c] - low[c]), 0.0f);
    }
    return AUTHOR_OK;
}

static uint32_t deepest(const author_depth *depth) {
    uint32_t most = 0;
    for (size_t i = 0; i < (size_t)depth->width * depth->height; i++)
        most = depth->texels[i] > most ? depth->texels[i] : most;
    return most;
}

author_result author_prune(author_run *run, author_picture *picture, const author_depth *depth) {
    prune p = {.picture = picture, .depth = depth};
    author_result result = AUTHOR_OK;
    uint32_t most = deepest(depth), w = picture->width, h = picture->height;
    while (result == AUTHOR_OK && p.level_count < MOST_LEVELS && w > 1 && h > 1 &&
           most >> p.level_count >= AUTHOR_PRUNE_MARGIN) {
        w = (w + 1) / 2;
        h = (h + 1) / 2;
        p.at = p.level_count++;
        result = author_picture_create(run, w, h, picture->channels, &p.levels[p.at]);
        if (result == AUTHOR_OK)
            result = author_for(run, "pruning", h, halve_row, &p);
    }
    if (result == AUTHOR_OK && p.level_count)
        result = author_for(run, "pruning", picture->height, prune_row, &p);
    for (int i = 0; i < p.level_count; i++)
        author_picture_release(&p.levels[i]);
    return result;
}

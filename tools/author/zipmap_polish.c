/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The last step of a pair: place and light are solved for together. refine_plane takes the light out first, which works
 * far from the place as well, but leaves a bias where pictures are smooth: a vignette that is not quite out moves a
 * soft edge, and so does a logarithm that levels off. A chain of zooms multiplies that. Here each channel of the coarse
 * picture is predicted as that of the fine one times a gain, which is a polynomial in the place and in the distance
 * from the centre of the fine picture; its coefficients are unknowns of the same equations as the homography, and so is
 * how much less sharp one picture is. Brightness near white is not looked at: noise decides there which texels are cut
 * off, and those that are left would be too dark on the average.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

enum {
    CHANNELS = 3,
    GAIN = 9,
    LIGHT = GAIN + 1, /* the gain's coefficients and the blur */
    ROW = MOTION + LIGHT,
    UNKNOWNS = MOTION + CHANNELS * LIGHT,
    STEPS = 20,
    SHARPENINGS = 3, /* times that sharpness is matched */
    MOST_PASSES = 24,
    LEAST_TEXELS = 500
};

static const double BRIGHTEST = 0.97; /* root of light, of the fine picture and of the prediction */
static const double DARK = 0.1;       /* roots well below count less: noise is strong there, and cut off at black */
static const double JITTER = 0.25;    /* texels that detail is off by itself: cameras sample, compress and sharpen */
static const double TOLERANCE = 3;    /* residuals of so many standard deviations count a quarter */
static const double REST = 0.0005;    /* texels of a step that is the last one; */
static const double NEARLY = 0.01;    /* of one that may be, when there were many */
static const double CLOSE = 0.05;     /* of one after which sharpness is matched */
static const double MOST_STEP = 1, MOST_MOVE = 1.5; /* texels */
static const double PASSES_PER_BLUR = 4;            /* of luma_soften */

typedef struct channel {
    view v;
    float *warped; /* the fine picture as the coarse one would show it */
    uint8_t *inside;
    double gain[GAIN], blur, noise;
} channel;

typedef struct texel {
    double residual, weight;
    double row[ROW];
} texel;

typedef struct solving {
    channel channels[CHANNELS];
    plane matrix;
    size_t width, height;
    double normal[UNKNOWNS * UNKNOWNS], right[UNKNOWNS];
    size_t count; /* of texels in the equations */
    residuals residuals;
} solving;

static void look(solving *s) {
    for (int c = 0; c < CHANNELS; c++) {
        channel *k = &s->channels[c];
        for (size_t i = 0; i < s->width * s->height; i++) {
            k->warped[i] = 0;
            k->inside[i] = !isnan(k->v.coarse.texels[i]) &&
                           view_average(&k->v, &s->matrix, i % s->width, i / s->width, &k->warped[i]);
        }
    }
}

static author_result open_channel(author_run *run, const photo *coarse, const photo *fine, uint32_t level, int c,
                                  solving *s) {
    channel *k = &s->channels[c];
    const float one[2][3] = {{c == 0, c == 1, c == 2}, {c == 0, c == 1, c == 2}};
    author_result result = view_open(run, &coarse->light, &fine->light, one, NAN, level, &s->matrix, &k->v);
    s->width = k->v.coarse.width;
    s->height = k->v.coarse.height;
    k->warped = author_alloc(run, s->width * s->height, sizeof *k->warped);
    k->inside = author_alloc(run, s->width * s->height, 1);
    k->gain[0] = 1;
    return result == AUTHOR_OK && (!k->warped || !k->inside) ? AUTHOR_NO_MEMORY : result;
}

static void release(solving *s) {
    for (int c = 0; s && c < CHANNELS; c++) {
        view_release(&s->channels[c].v);
        free(s->channels[c].warped);
        free(s->channels[c].inside);
    }
    free(s);
}

/* ---- one texel ---------------------------------------------------------------------------------------------- */

/* What the gain is made of, at a place of the box (-1 to 1). */
static void gains_at(const solving *s, size_t x, size_t y, const double place[2], double basis[GAIN]) {
    const view *v = &s->channels[0].v;
    double px = ((double)(v->box[0] + x) + 0.5) / v->size[0], py = ((double)(v->box[1] + y) + 0.5) / v->size[1];
    double u = 0.5, w = 0.5, a = place[0], b = place[1];
    plane_apply(&s->matrix, px, py, &u, &w);
    u = 2 * u - 1;
    w = (2 * w - 1) * v->fine.height / v->fine.width;
    double r = u * u + w * w;
    const double all[GAIN] = {1, a, b, a * a, a * b, b * b, r, r * r, r * r * r};
    memcpy(basis, all, sizeof all);
}

static bool is_within(const solving *s, const channel *k, size_t x, size_t y) {
    const uint8_t *inside = k->inside + y * s->width + x;
    return x > 0 && y > 0 && x + 1 < s->width && y + 1 < s->height && inside[0] && inside[-1] && inside[1] &&
           *(inside - s->width) && inside[s->width];
}

/* Of the noise, and of what sharp detail differs by for other reasons: no edge counts for more than its share. */
static double weight_of(const channel *k, double residual, const double gradient[2]) {
    double strength = gradient[0] * gradient[0] + gradient[1] * gradient[1];
    double variance = k->noise * k->noise + JITTER * JITTER * strength;
    double excess = 1 + residual * residual / (TOLERANCE * TOLERANCE * variance);
    return k->noise > 0 ? 1 / (variance * excess * excess) : 1;
}

/* Roots of light r are compared as sqrt(r^2 + DARK^2). False where nothing can be said. */
static bool texel_at(const solving *s, const channel *k, size_t x, size_t y, texel *out) {
    const float *warped = k->warped + y * s->width + x;
    if (!is_within(s, k, x, y) || (double)warped[0] > BRIGHTEST)
        return false;
    double up = (double)*(warped - s->width), down = (double)warped[s->width];
    double left = (double)warped[-1], right = (double)warped[1], fine = (double)warped[0];
    double place[2] = {((double)x + 0.5) * 2 / (double)s->width - 1, ((double)y + 0.5) * 2 / (double)s->height - 1};
    double basis[GAIN], gain = 0, softer = (left + right + up + down) / 4 - fine;
    gains_at(s, x, y, place, basis);
    for (int i = 0; i < GAIN; i++)
        gain += k->gain[i] * basis[i];
    double root = gain * fine + k->blur * softer, coarse = (double)k->v.coarse.texels[y * s->width + x];
    if (root > BRIGHTEST)
        return false;
    double level = sqrt(root * root + DARK * DARK), slope = root / level;
    double gradient[2] = {slope * gain * (right - left) / 2, slope * gain * (down - up) / 2};
    out->residual = sqrt(coarse * coarse + DARK * DARK) - level;
    out->weight = weight_of(k, out->residual, gradient);
    motion_row(&k->v, place, gradient, out->row);
    for (int i = 0; i < GAIN; i++)
        out->row[MOTION + i] = slope * fine * basis[i];
    out->row[MOTION + GAIN] = slope * softer;
    return true;
}

/* ---- one step ----------------------------------------------------------------------------------------------- */

/* Adds a channel's equations: all have the motion in common, and each has its own light. */
static void add_channel(solving *s, int c) {
    double normal[ROW][ROW] = {{0}}, right[ROW] = {0};
    texel t;
    for (size_t i = 0; i < s->width * s->height; i++) {
        if (!texel_at(s, &s->channels[c], i % s->width, i / s->width, &t))
            continue;
        s->count++;
        for (int r = 0; r < ROW; r++) {
            double scaled = t.weight * t.row[r];
            right[r] += scaled * t.residual;
            for (int k = 0; k <= r; k++)
                normal[r][k] += scaled * t.row[k];
        }
    }
    for (int r = 0; r < ROW; r++) {
        int row = r < MOTION ? r : r + c * LIGHT;
        s->right[row] += right[r];
        for (int k = 0; k <= r; k++)
            s->normal[row * UNKNOWNS + (k < MOTION ? k : k + c * LIGHT)] += normal[r][k];
    }
}

static void add_all(solving *s) {
    memset(s->normal, 0, sizeof s->normal);
    memset(s->right, 0, sizeof s->right);
    s->count = 0;
    for (int c = 0; c < CHANNELS; c++)
        add_channel(s, c);
    for (int i = 0; i < UNKNOWNS; i++)
        s->normal[i * UNKNOWNS + i] = s->normal[i * UNKNOWNS + i] * (1 + 1e-9) + 1e-12;
}

static void measure_noise(solving *s) {
    texel t;
    for (int c = 0; c < CHANNELS; c++) {
        memset(&s->residuals, 0, sizeof s->residuals);
        for (size_t i = 0; i < s->width * s->height; i++)
            if (texel_at(s, &s->channels[c], i % s->width, i / s->width, &t))
                residuals_add(&s->residuals, t.residual);
        s->channels[c].noise = residuals_deviation(&s->residuals);
    }
}

/* All unknowns of the step, or those of the light alone. */
static bool solve(const solving *s, bool moving, double step[UNKNOWNS]) {
    double a[UNKNOWNS * UNKNOWNS];
    memcpy(a, s->normal, sizeof a);
    memcpy(step, s->right, sizeof s->right);
    for (int i = 0; !moving && i < UNKNOWNS; i++)
        for (int j = 0; j < MOTION && j <= i; j++)
            a[i * UNKNOWNS + j] = i == j;
    for (int i = 0; !moving && i < MOTION; i++)
        step[i] = 0;
    return s->count >= LEAST_TEXELS && plane_solve(a, step, UNKNOWNS);
}

static void add_light(solving *s, const double step[UNKNOWNS]) {
    for (int c = 0; c < CHANNELS; c++) {
        for (int i = 0; i < GAIN; i++)
            s->channels[c].gain[i] += step[MOTION + c * LIGHT + i];
        s->channels[c].blur += step[MOTION + c * LIGHT + GAIN];
    }
}

/* Makes the fine picture less sharp where the coarse one clearly is; false when there is nothing to do. */
static bool match_sharpness(solving *s) {
    double blur = 0;
    for (int c = 0; c < CHANNELS; c++)
        blur += s->channels[c].blur / CHANNELS;
    double passes = fmin(floor(blur * PASSES_PER_BLUR + 0.5), MOST_PASSES);
    for (int c = 0; c < CHANNELS && passes >= 1; c++) {
        luma_soften(&s->channels[c].v.fine, (unsigned)passes);
        s->channels[c].blur -= passes / PASSES_PER_BLUR;
    }
    return passes >= 1;
}

/* Steps until they are nothing. False: they do not end, or far off. */
static bool settle(solving *s) {
    double step[UNKNOWNS], far = HUGE_VAL, moved = 0;
    int sharpenings = 0;
    look(s);
    add_all(s);
    if (!solve(s, false, step))
        return false;
    add_light(s, step);
    measure_noise(s);
    for (int i = 0; i < STEPS && far >= REST; i++) {
        add_all(s);
        if (!solve(s, true, step))
            return false;
        far = motion_travel(&s->channels[0].v, step);
        moved += far;
        if (!(far < MOST_STEP && moved < MOST_MOVE))
            return false;
        motion_apply(&s->channels[0].v, step, &s->matrix);
        add_light(s, step);
        bool softer = far < CLOSE && sharpenings < SHARPENINGS && match_sharpness(s);
        sharpenings += far < CLOSE ? softer ? 1 : SHARPENINGS : 0;
        far = softer ? HUGE_VAL : far;
        look(s);
        measure_noise(s);
    }
    return far < NEARLY && plane_normalise(&s->matrix);
}

author_result pair_polish(author_run *run, const photo *photos, size_t texels, edge *e) {
    const photo *coarse = &photos[e->coarse], *fine = &photos[e->fine];
    double box[4];
    if (!view_footprint(&e->matrix, box))
        return AUTHOR_OK;
    solving *s = author_alloc(run, 1, sizeof *s);
    author_result result = s ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (s)
        s->matrix = e->matrix;
    for (int c = 0; c < CHANNELS && result == AUTHOR_OK; c++)
        result = open_channel(run, coarse, fine, view_level(&coarse->light, box, texels), c, s);
    if (result == AUTHOR_OK && settle(s) && plane_plausible(&s->matrix, coarse->pixels, fine->pixels)) {
        add_all(s);
        const view *v = &s->channels[0].v;
        e->matrix = s->matrix;
        e->ratio = plane_ratio(&s->matrix, coarse->pixels, fine->pixels);
        e->contained = plane_contained(&s->matrix);
        e->spread = plane_ratio(&s->matrix, v->size, fine->pixels) * motion_spread(v, s->normal, UNKNOWNS);
    }
    release(s);
    return result;
}

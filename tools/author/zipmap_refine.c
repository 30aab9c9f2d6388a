/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sub-pixel refinement of one pair: Gauss-Newton on brightness, from coarse to fine. The coarse picture's texels stay
 * as they are; what moves is the fine picture, averaged over the area of each of them, because it can be sampled
 * without aliasing. What is compared are logarithms, less a polynomial and the mean of their surroundings: exposure and
 * vignetting are factors that vary slowly, and drop out. Residuals count with the brightness, because noise grows in
 * the logarithm where it is dark. The contrast may differ, and one picture may be less sharp. All unknowns, 8 of the
 * homography and these 2, are solved for together; texels that disagree count less (Geman and McClure 1987).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

enum {
    CONTRAST = MOTION,
    BLUR,
    UNKNOWNS,
    SMOOTH = 7, /* coefficients of what light and lens do */
    STEPS = 14,
    LEAST_SPAN = 20, /* texels along the shorter side of the footprint, on the coarsest level used */
    LEAST_REACH = 3, /* of the surroundings, in texels to each side, twice; */
    MOST_REACH = 12, /* a tenth of the footprint's shorter side in between */
    BLOCKS = 6,      /* along each side, of the residual */
    MOST_PASSES = 24,
    SHARPENINGS = 2 /* times that sharpness is matched */
};

static const double MOST_TRAVEL = 0.35;  /* of the footprint's width, in one step */
static const double MOST_WORSE = 1.1;    /* by what factor the noise may grow on the way */
static const double MOST_DRIFT = 0.1;    /* of the fine picture's size, that a corner ends from where it began */
static const float DARK = 0.03F;         /* brightness below which logarithms level off */
static const double PASSES_PER_BLUR = 4; /* a pass adds an eighth of a squared texel of variance, a blur of 1 a half */
static const double JITTER = 0.1;        /* texels that detail is off by itself: cameras sample, compress and sharpen */
static const double TOLERANCE = 3;       /* residuals of so many standard deviations count a quarter */

typedef struct model {
    view v;
    uint32_t reach; /* of the surroundings */
    double contrast, blur;
    double noise;              /* standard deviation of the residual; 0: all texels count the same */
    luma_level warped;         /* the fine picture as the coarse one would show it */
    uint8_t *inside;           /* where it does */
    luma_level coarse, detail; /* of both, what differs from the surroundings */
} model;

typedef struct texel {
    double coarse, fine, blur, gradient[2]; /* gradient of fine and what it gains by a blur, per texel */
    double s, t;                            /* place in the footprint's box, -1 to 1 */
    double bright;                          /* what all of these are multiplied by */
    double residual, weight;
} texel;

typedef struct sums {
    double normal[UNKNOWNS * UNKNOWNS], right[UNKNOWNS];
    residuals residuals;
} sums;

/* ---- the fine picture in the frame of the coarse one ------------------------------------------------------ */

static float logarithm(float root) {
    return logf(fmaxf(root, 0) + DARK);
}

static double place_of(size_t i, uint32_t count) {
    return ((double)i + 0.5) * 2 / count - 1;
}

static void warp(model *m, const plane *matrix) {
    for (size_t y = 0; y < m->warped.height; y++)
        for (size_t x = 0; x < m->warped.width; x++) {
            size_t i = y * m->warped.width + x;
            float root = 0;
            m->inside[i] = !isnan(m->v.coarse.texels[i]) && view_average(&m->v, matrix, x, y, &root);
            m->warped.texels[i] = logarithm(root);
        }
}

static author_result model_open(author_run *run, const photo *coarse, const photo *fine, const float weights[2][3],
                                uint32_t level, const plane *matrix, model *out) {
    *out = (model){.contrast = 1};
    author_result result = view_open(run, &coarse->light, &fine->light, weights, NAN, level, matrix, &out->v);
    uint32_t shorter = out->v.coarse.width < out->v.coarse.height ? out->v.coarse.width : out->v.coarse.height;
    out->reach = shorter / 10 < LEAST_REACH ? LEAST_REACH : shorter / 10 < MOST_REACH ? shorter / 10 : MOST_REACH;
    if (result == AUTHOR_OK)
        result = luma_level_create(run, out->v.coarse.width, out->v.coarse.height, &out->warped);
    if (result == AUTHOR_OK)
        result = luma_level_create(run, out->v.coarse.width, out->v.coarse.height, &out->coarse);
    if (result == AUTHOR_OK)
        result = luma_level_create(run, out->v.coarse.width, out->v.coarse.height, &out->detail);
    size_t count = (size_t)out->v.coarse.width * out->v.coarse.height;
    out->inside = author_alloc(run, count, 1);
    for (size_t i = 0; i < count && out->v.coarse.texels; i++)
        if (!isnan(out->v.coarse.texels[i]))
            out->v.coarse.texels[i] = logarithm(out->v.coarse.texels[i]);
    return out->inside ? result : AUTHOR_NO_MEMORY;
}

static void model_release(model *m) {
    view_release(&m->v);
    free(m->warped.texels);
    free(m->coarse.texels);
    free(m->detail.texels);
    free(m->inside);
    *m = (model){0};
}

static void smooth_of(const model *m, size_t i, double basis[SMOOTH]) {
    double s = place_of(i % m->warped.width, m->warped.width), t = place_of(i / m->warped.width, m->warped.height);
    const double all[SMOOTH] = {1, s, t, s * s, s * t, t * t, (s * s + t * t) * (s * s + t * t)};
    memcpy(basis, all, sizeof all);
}

/* Adds the polynomial that brings the warped picture closest to the coarse one: exposure, and vignetting of both
 * lenses. */
static void equalise(model *m) {
    double normal[SMOOTH * SMOOTH] = {0}, right[SMOOTH] = {0}, basis[SMOOTH];
    size_t count = (size_t)m->warped.width * m->warped.height;
    for (size_t i = 0; i < count; i++) {
        if (!m->inside[i])
            continue;
        smooth_of(m, i, basis);
        double bright = exp((double)m->v.coarse.texels[i]), weight = bright * bright;
        for (int r = 0; r < SMOOTH; r++) {
            right[r] += weight * basis[r] * (double)(m->v.coarse.texels[i] - m->warped.texels[i]);
            for (int c = 0; c <= r; c++)
                normal[r * SMOOTH + c] += weight * basis[r] * basis[c];
        }
    }
    if (!plane_solve(normal, right, SMOOTH))
        return;
    for (size_t i = 0; i < count; i++) {
        smooth_of(m, i, basis);
        for (int r = 0; r < SMOOTH && m->inside[i]; r++)
            m->warped.texels[i] += (float)(right[r] * basis[r]);
    }
}

/* Both pictures less their surroundings. */
static author_result look(author_run *run, model *m, const plane *matrix, uint32_t reach) {
    warp(m, matrix);
    equalise(m);
    author_result result = luma_detail(run, &m->v.coarse, m->inside, reach, &m->coarse);
    return result == AUTHOR_OK ? luma_detail(run, &m->warped, m->inside, reach, &m->detail) : result;
}

/* ---- one texel -------------------------------------------------------------------------------------------- */

/* Of the noise, and of what sharp detail differs by for other reasons: so no edge, however strong, counts for more than
 * its share. */
static double weight_of(const model *m, const texel *t) {
    double strength = t->gradient[0] * t->gradient[0] + t->gradient[1] * t->gradient[1];
    double noise = m->noise * m->noise, variance = noise + JITTER * JITTER * strength;
    double excess = 1 + t->residual * t->residual / (TOLERANCE * TOLERANCE * variance);
    return noise / variance / (excess * excess);
}

/* False at the edge of what both show. */
static bool texel_at(const model *m, size_t x, size_t y, texel *out) {
    size_t w = m->coarse.width, h = m->coarse.height, i = y * w + x;
    const float *fine = m->detail.texels + i;
    if (!m->inside[i] || x == 0 || y == 0 || x + 1 == w || y + 1 == h || !m->inside[i - 1] || !m->inside[i + 1] ||
        !m->inside[i - w] || !m->inside[i + w])
        return false;
    double bright = out->bright = exp((double)m->v.coarse.texels[i]), scale = bright * m->contrast;
    out->coarse = bright * (double)m->coarse.texels[i];
    out->fine = bright * (double)fine[0];
    out->gradient[0] = scale * (double)(fine[1] - fine[-1]) / 2;
    out->gradient[1] = scale * (double)(fine[w] - *(fine - w)) / 2;
    out->blur = bright * (double)((fine[1] + fine[-1] + fine[w] + *(fine - w)) / 4 - fine[0]);
    out->s = place_of(x, m->coarse.width);
    out->t = place_of(y, m->coarse.height);
    out->residual = out->coarse - (m->contrast * out->fine + m->blur * out->blur);
    out->weight = m->noise > 0 ? weight_of(m, out) : 1;
    return true;
}

/* How the prediction changes with the unknowns. */
static void row_of(const model *m, const texel *p, double row[UNKNOWNS]) {
    const double place[2] = {p->s, p->t};
    motion_row(&m->v, place, p->gradient, row);
    row[CONTRAST] = p->fine;
    row[BLUR] = p->blur;
}

/* ---- one step --------------------------------------------------------------------------------------------- */

static void add_texel(sums *s, const model *m, const texel *t) {
    double row[UNKNOWNS];
    row_of(m, t, row);
    for (int i = 0; i < UNKNOWNS; i++) {
        double scaled = t->weight * row[i];
        s->right[i] += scaled * t->residual;
        for (int j = 0; j <= i; j++)
            s->normal[i * UNKNOWNS + j] += scaled * row[j];
    }
    residuals_add(&s->residuals, t->residual);
}

static void add_all(const model *m, sums *out) {
    memset(out, 0, sizeof *out);
    for (size_t y = 0; y < m->coarse.height; y++)
        for (size_t x = 0; x < m->coarse.width; x++) {
            texel t;
            if (texel_at(m, x, y, &t))
                add_texel(out, m, &t);
        }
}

/* Solves for the first `moving` unknowns of the motion and those of the light; the others stay 0. */
static bool solve(const sums *s, int moving, double step[UNKNOWNS]) {
    double a[UNKNOWNS * UNKNOWNS];
    memcpy(a, s->normal, sizeof a);
    memcpy(step, s->right, sizeof s->right);
    if (s->residuals.count < 4 * (size_t)UNKNOWNS)
        return false;
    for (int i = 0; i < UNKNOWNS; i++) {
        bool held = i >= moving && i < MOTION;
        for (int j = 0; j < i; j++)
            if (held || (j >= moving && j < MOTION))
                a[i * UNKNOWNS + j] = 0;
        a[i * UNKNOWNS + i] = held ? 1 : a[i * UNKNOWNS + i] * (1 + 1e-9);
        step[i] = held ? 0 : step[i];
    }
    return plane_solve(a, step, UNKNOWNS);
}

/* ---- one level -------------------------------------------------------------------------------------------- */

/* Brings contrast and sharpness of both together, with the matrix as it is. */
static author_result fit_light(author_run *run, model *m, const plane *matrix, uint32_t reach, sums *s, bool *fits) {
    double step[UNKNOWNS];
    author_result result = look(run, m, matrix, reach);
    m->noise = 0;
    if (result == AUTHOR_OK)
        add_all(m, s);
    *fits = result == AUTHOR_OK && solve(s, 0, step);
    if (!*fits)
        return result;
    m->contrast += step[CONTRAST];
    m->blur += step[BLUR];
    add_all(m, s);
    m->noise = residuals_deviation(&s->residuals);
    return AUTHOR_OK;
}

typedef struct state {
    plane matrix;
    double contrast, blur, noise;
} state;

/* One step; *far is how far it went, in texels. False where the texels do not say. */
static bool take_step(model *m, plane *matrix, int moving, const sums *s, double *far) {
    double step[UNKNOWNS];
    if (!solve(s, moving, step))
        return false;
    *far = motion_travel(&m->v, step);
    if (!(*far < MOST_TRAVEL * m->v.coarse.width))
        return false;
    motion_apply(&m->v, step, matrix);
    m->contrast += step[CONTRAST];
    m->blur += step[BLUR];
    return true;
}

/* Lets the first `moving` unknowns of the motion move until they rest, or until that makes things worse: then the best
 * that was there stays. *rests is false where they cannot even begin. */
static author_result settle(author_run *run, model *m, plane *matrix, int moving, double rest, sums *s, bool *rests) {
    state best = {.noise = HUGE_VAL};
    author_result result = AUTHOR_OK;
    *rests = false;
    for (int i = 0; i <= STEPS && result == AUTHOR_OK; i++) {
        double far;
        add_all(m, s);
        m->noise = residuals_deviation(&s->residuals);
        if (m->noise < best.noise)
            best = (state){*matrix, m->contrast, m->blur, m->noise};
        if (m->noise > best.noise * MOST_WORSE)
            break;
        add_all(m, s);
        if (i == STEPS || !take_step(m, matrix, moving, s, &far))
            break;
        *rests = true;
        result = look(run, m, matrix, m->reach);
        if (far < rest)
            return result;
    }
    *matrix = best.matrix;
    m->contrast = best.contrast;
    m->blur = best.blur;
    m->noise = best.noise;
    return result == AUTHOR_OK ? look(run, m, matrix, m->reach) : result;
}

/* ---- how good it is --------------------------------------------------------------------------------------- */

typedef struct agreement {
    double a, b, aa, bb, ab, count;
} agreement;

static void agree(agreement *sum, double a, double b) {
    sum->a += a;
    sum->b += b;
    sum->aa += a * a;
    sum->bb += b * b;
    sum->ab += a * b;
    sum->count++;
}

static double correlation_of(const model *m) {
    agreement g = {0};
    for (size_t y = 0; y < m->coarse.height; y++)
        for (size_t x = 0; x < m->coarse.width; x++) {
            texel t;
            if (texel_at(m, x, y, &t))
                agree(&g, t.coarse, t.coarse - t.residual);
        }
    double n = g.count > 0 ? g.count : 1, aa = g.aa - g.a * g.a / n, bb = g.bb - g.b * g.b / n;
    return aa > 0 && bb > 0 ? (g.ab - g.a * g.b / n) / sqrt(aa * bb) : 0;
}

typedef struct block {
    double ss, st, tt, sr, tr; /* of gradients per texel, and of the residual */
    double s, t, weight;       /* sums of places */
} block;

static void add_to_block(block *blocks, const texel *p) {
    int column = (int)((p->s + 1) / 2 * BLOCKS), line = (int)((p->t + 1) / 2 * BLOCKS);
    block *b = &blocks[(line < BLOCKS ? line : BLOCKS - 1) * BLOCKS + (column < BLOCKS ? column : BLOCKS - 1)];
    double gs = p->gradient[0], gt = p->gradient[1];
    b->ss += p->weight * gs * gs;
    b->st += p->weight * gs * gt;
    b->tt += p->weight * gt * gt;
    b->sr += p->weight * gs * p->residual;
    b->tr += p->weight * gt * p->residual;
    b->s += p->weight * p->s;
    b->t += p->weight * p->t;
    b->weight += p->weight;
}

/* What each block would still move, and how much of that is a radial lens distortion. Blocks without detail say
 * nothing. */
static void measure_blocks(const model *m, double ratio, refine_result *out) {
    block blocks[BLOCKS * BLOCKS] = {{0}};
    double squares = 0, count = 0, along = 0, length = 0, w = m->coarse.width, h = m->coarse.height;
    for (size_t y = 0; y < m->coarse.height; y++)
        for (size_t x = 0; x < m->coarse.width; x++) {
            texel t;
            if (texel_at(m, x, y, &t))
                add_to_block(blocks, &t);
        }
    for (int i = 0; i < BLOCKS * BLOCKS; i++) {
        const block *b = &blocks[i];
        double d = b->ss * b->tt - b->st * b->st, trace = b->ss + b->tt;
        double least = trace / 2 - sqrt(fmax(trace * trace / 4 - d, 0));
        if (!(b->weight > 16) || !(d > 0) || !(m->noise * m->noise * ratio * ratio < least))
            continue;
        double dx = (b->tt * b->sr - b->st * b->tr) / d, dy = (b->ss * b->tr - b->st * b->sr) / d;
        squares += dx * dx + dy * dy;
        count++;
        double x = b->s / b->weight * w / 2, y = b->t / b->weight * h / 2, r = (x * x + y * y) / (w * w + h * h) * 4;
        along += dx * r * x + dy * r * y;
        length += r * r * (x * x + y * y);
    }
    out->residual = count > 0 ? ratio * sqrt(squares / count) : 0;
    out->distortion = length > 0 ? ratio * along / length * hypot(w, h) / 2 : 0;
}

static author_result measure(author_run *run, model *m, const photo *fine, sums *s, refine_result *out) {
    double ratio = plane_ratio(&out->matrix, m->v.size, fine->pixels);
    add_all(m, s);
    out->error = m->noise;
    out->spread = ratio * m->noise * motion_spread(&m->v, s->normal, UNKNOWNS);
    out->local_correlation = correlation_of(m);
    measure_blocks(m, ratio, out);
    bool fits;
    uint32_t shorter = m->coarse.width < m->coarse.height ? m->coarse.width : m->coarse.height;
    author_result result = fit_light(run, m, &out->matrix, shorter / 8 + 1, s, &fits);
    out->correlation = fits ? correlation_of(m) : 0;
    return result;
}

/* ---- from coarse to fine ---------------------------------------------------------------------------------- */

/* Where the coarse picture is clearly less sharp, the fine one is made so: the linear term would not do. *softer: it
 * was. */
static author_result match_sharpness(author_run *run, model *m, const plane *matrix, bool *softer) {
    double passes = floor(m->blur * PASSES_PER_BLUR + 0.5);
    *softer = passes >= 1;
    if (!*softer)
        return AUTHOR_OK;
    luma_soften(&m->v.fine, passes < MOST_PASSES ? (unsigned)passes : MOST_PASSES);
    m->blur = 0;
    return look(run, m, matrix, m->reach);
}

/* Moves by steps, sharpness and steps again. */
static author_result settle_all(author_run *run, model *m, plane *matrix, double rest, sums *s, bool *rests) {
    bool softer = true;
    author_result result = settle(run, m, matrix, MOTION, rest, s, rests);
    for (int i = 0; i < SHARPENINGS && softer && *rests && result == AUTHOR_OK; i++) {
        result = match_sharpness(run, m, matrix, &softer);
        if (softer && result == AUTHOR_OK)
            result = settle(run, m, matrix, MOTION, rest, s, rests);
    }
    return result;
}

static author_result refine_level(author_run *run, const photo *coarse, const photo *fine, const float weights[2][3],
                                  uint32_t level, bool first, bool last, refine_result *out) {
    model m;
    sums *s = author_alloc(run, 1, sizeof *s);
    author_result result = s ? model_open(run, coarse, fine, weights, level, &out->matrix, &m) : AUTHOR_NO_MEMORY;
    out->converged = false;
    if (result == AUTHOR_OK)
        result = fit_light(run, &m, &out->matrix, m.reach, s, &out->converged);
    if (out->converged && first && result == AUTHOR_OK)
        result = settle(run, &m, &out->matrix, 6, 0.05, s, &out->converged);
    if (out->converged && result == AUTHOR_OK)
        result = settle_all(run, &m, &out->matrix, last ? 0.002 : 0.02, s, &out->converged);
    if (out->converged && last && result == AUTHOR_OK)
        result = measure(run, &m, fine, s, out);
    if (s)
        model_release(&m);
    free(s);
    return result;
}

/* The coarsest level to begin with: up to three above the finest, while the footprint has enough texels. */
static uint32_t first_level(const luma *light, const double box[4], uint32_t finest) {
    uint32_t level = finest;
    while (level + 1 < light->count && level < finest + 3 &&
           fmin((box[2] - box[0]) * light->level[level + 1].width,
                (box[3] - box[1]) * light->level[level + 1].height) >= LEAST_SPAN)
        level++;
    return level;
}

/* The farthest that a corner of the fine picture is from where it was, in its coordinates. */
static double drift(const plane *before, const plane *after) {
    plane back;
    double most = 0;
    bool good = plane_inverse(before, &back);
    for (int i = 0; i < 4 && good; i++) {
        double x, y, u, v;
        good = plane_apply(&back, i & 1, i >> 1, &x, &y) && plane_apply(after, x, y, &u, &v);
        most = good ? fmax(most, hypot(u - (i & 1), v - (i >> 1))) : most;
    }
    return good ? most : HUGE_VAL;
}

author_result refine_plane(author_run *run, const photo *coarse, const photo *fine, const plane *start, size_t texels,
                           refine_result *out) {
    double box[4];
    *out = (refine_result){.matrix = *start};
    if (!view_footprint(start, box))
        return AUTHOR_OK;
    uint32_t finest = view_level(&coarse->light, box, texels), count = first_level(&coarse->light, box, finest) + 1;
    float weights[2][3];
    author_result result = view_balance(run, &coarse->light, &fine->light, start, weights);
    for (uint32_t level = count; level-- > finest && result == AUTHOR_OK;) {
        plane before = out->matrix;
        bool first = level + 1 == count, last = level == finest;
        result = refine_level(run, coarse, fine, weights, level, first, last, out);
        if (!last && !out->converged)
            out->matrix = before; /* too few texels: the next level begins where this one did */
    }
    out->converged = out->converged && plane_normalise(&out->matrix) && drift(start, &out->matrix) < MOST_DRIFT;
    return result;
}

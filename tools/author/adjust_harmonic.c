/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The Laplace equation on a rectangle with given border, by multigrid (Brandt 1977): red-black relaxation, bilinear
 * interpolation and its transpose, starting from the solution on the next coarser grid. A coarser grid has every second
 * line and the last one, so that any size will do; its cells are then of unequal width, and the five-point star is
 * weighted by their widths.
 *
 * Each plane is one thread's work from beginning to end: the result does not depend on the number of threads.
 */
#include "author_adjust.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LEVELS 32
#define COARSEST 4     /* lines a side, that are relaxed until nothing changes */
#define MOST_CYCLES 12 /* on the finest grid */
#define ENOUGH 1e-5f   /* of the border's range: the last correction */

/* One direction of a grid. */
typedef struct axis {
    uint32_t size;
    double *at;                   /* position of each line */
    float *before, *after;        /* weight of the neighbours in the second derivative */
    uint32_t *coarse;             /* line of the coarser axis at or before this one */
    float *share;                 /* of the next coarser line */
    float *left, *centre, *right; /* coarser axis: weights of the finer lines around each of its lines */
} axis;

typedef struct grid {
    axis x, y;
    float *u, *f, *r;  /* solution, right side, residual */
    float *line;       /* scratch, one row */
    float *odd, *even; /* 1 on every second texel */
    float *inverse;    /* of the star's sum, for the row at hand */
} grid;

typedef struct pyramid {
    grid grids[MOST_LEVELS];
    int count;
    int failed; /* no memory */
    void *blocks[MOST_LEVELS * 24];
    int block_count;
} pyramid;

static void *block(pyramid *p, size_t count, size_t size) {
    void *memory = count > SIZE_MAX / size ? NULL : calloc(count, size);
    if (memory)
        p->blocks[p->block_count++] = memory;
    else
        p->failed = 1;
    return memory;
}

/* ---- grids ------------------------------------------------------------------------------------------------- */

static int make_axis(pyramid *p, axis *a, uint32_t size) {
    a->size = size;
    a->at = block(p, size, sizeof *a->at);
    a->before = block(p, size, sizeof(float));
    a->after = block(p, size, sizeof(float));
    a->coarse = block(p, size, sizeof *a->coarse);
    a->share = block(p, size, sizeof(float));
    a->left = block(p, size, sizeof(float));
    a->centre = block(p, size, sizeof(float));
    a->right = block(p, size, sizeof(float));
    return !p->failed;
}

static void weigh_axis(axis *a) {
    for (uint32_t i = 1; i + 1 < a->size; i++) {
        double l = a->at[i] - a->at[i - 1], r = a->at[i + 1] - a->at[i];
        a->before[i] = (float)(2.0 / (l * (l + r)));
        a->after[i] = (float)(2.0 / (r * (l + r)));
    }
}

static uint32_t coarser_size(uint32_t size) {
    return size <= COARSEST ? size : size / 2 + 1;
}

static uint32_t fine_line(const axis *fine, const axis *coarse, uint32_t i) {
    return coarse->size == fine->size ? i : i + 1 == coarse->size ? fine->size - 1 : 2 * i;
}

/* Between an axis and the coarser one: where each fine line lies, and the transpose, by widths. */
static void link_axes(axis *fine, axis *coarse) {
    for (uint32_t i = 0; i < coarse->size; i++)
        coarse->at[i] = fine->at[fine_line(fine, coarse, i)];
    for (uint32_t i = 0, c = 0; i < fine->size; i++) {
        while (c + 1 < coarse->size && coarse->at[c + 1] <= fine->at[i])
            c++;
        fine->coarse[i] = c;
        fine->share[i] = c + 1 == coarse->size
                             ? 0.0f
                             : (float)((fine->at[i] - coarse->at[c]) / (coarse->at[c + 1] - coarse->at[c]));
    }
    for (uint32_t i = 1; i + 1 < coarse->size; i++) {
        uint32_t m = fine_line(fine, coarse, i);
        double weights[3] = {0}, sum = 0.0;
        for (uint32_t k = m - 1; k <= m + 1 && coarse->size != fine->size; k++) {
            double width = k > 0 && k + 1 < fine->size ? (fine->at[k + 1] - fine->at[k - 1]) / 2.0 : 0.0;
            double share = fine->coarse[k] == i       ? 1.0 - (double)fine->share[k]
                           : fine->coarse[k] + 1 == i ? (double)fine->share[k]
                                                      : 0.0;
            weights[k + 1 - m] = width * share;
            sum += width * share;
        }
        coarse->left[i] = sum > 0.0 ? (float)(weights[0] / sum) : 0.0f;
        coarse->centre[i] = sum > 0.0 ? (float)(weights[1] / sum) : 1.0f;
        coarse->right[i] = sum > 0.0 ? (float)(weights[2] / sum) : 0.0f;
    }
}

static int make_grid(pyramid *p, grid *g, uint32_t width, uint32_t height, int finest) {
    size_t texels = (size_t)width * height;
    if (!make_axis(p, &g->x, width) || !make_axis(p, &g->y, height))
        return 0;
    if (!finest)
        g->u = block(p, texels, sizeof(float));
    g->f = finest ? NULL : block(p, texels, sizeof(float));
    g->r = block(p, texels, sizeof(float));
    g->line = block(p, width, sizeof(float));
    g->inverse = block(p, width, sizeof(float));
    g->odd = block(p, width, sizeof(float));
    g->even = block(p, width, sizeof(float));
    for (uint32_t i = 0; !p->failed && i < width; i++) {
        g->odd[i] = (float)(i & 1);
        g->even[i] = (float)(1 - (i & 1));
    }
    return !p->failed;
}

static int make_pyramid(pyramid *p, float *plane, uint32_t width, uint32_t height) {
    for (; p->count < MOST_LEVELS; p->count++) {
        grid *g = &p->grids[p->count];
        if (!make_grid(p, g, width, height, p->count == 0))
            return 0;
        if (p->count == 0) {
            g->u = plane;
            for (uint32_t i = 0; i < width; i++)
                g->x.at[i] = i;
            for (uint32_t i = 0; i < height; i++)
                g->y.at[i] = i;
        } else {
            link_axes(&p->grids[p->count - 1].x, &g->x);
            link_axes(&p->grids[p->count - 1].y, &g->y);
        }
        weigh_axis(&g->x);
        weigh_axis(&g->y);
        if (coarser_size(width) == width && coarser_size(height) == height)
            break;
        width = coarser_size(width);
        height = coarser_size(height);
    }
    p->count++;
    return 1;
}

/* ---- relaxation -------------------------------------------------------------------------------------------- */

/* What the star of row y leaves over, star u - f, into g->line. Differences of neighbours are exact where u is smooth,
 * so that rounding does not add up over the plane. */
static void find_rest(const grid *g, uint32_t y) {
    uint32_t w = g->x.size;
    const float *row = g->u + (size_t)y * w, *up = row - w, *down = row + w;
    const float *before = g->x.before, *after = g->x.after;
    float above = g->y.before[y], below = g->y.after[y];
    float *restrict line = g->line;
    for (uint32_t x = 1; x + 1 < w; x++)
        line[x] = (before[x] * (row[x - 1] - row[x]) + after[x] * (row[x + 1] - row[x])) +
                  (above * (up[x] - row[x]) + below * (down[x] - row[x]));
    if (!g->f)
        return;
    const float *f = g->f + (size_t)y * w;
    for (uint32_t x = 1; x + 1 < w; x++)
        line[x] -= f[x];
}

/* Every second texel of each row, as on a chessboard; the others are computed too and not taken, which keeps the loop
 * straight. */
static void relax(grid *g, uint32_t colour) {
    uint32_t w = g->x.size;
    const float *before = g->x.before, *after = g->x.after;
    float across = 0.0f;
    for (uint32_t y = 1; y + 1 < g->y.size; y++) {
        float *restrict row = g->u + (size_t)y * w;
        float *restrict inverse = g->inverse;
        const float *chosen = (y + colour) & 1 ? g->odd : g->even, *line = g->line;
        if (across != g->y.before[y] + g->y.after[y]) {
            across = g->y.before[y] + g->y.after[y];
            for (uint32_t x = 1; x + 1 < w; x++)
                inverse[x] = 1.0f / (before[x] + after[x] + across);
        }
        find_rest(g, y);
        for (uint32_t x = 1; x + 1 < w; x++)
            row[x] += chosen[x] * inverse[x] * line[x];
    }
}

static void relax_both(grid *g, int times) {
    for (int i = 0; i < times; i++) {
        relax(g, 0);
        relax(g, 1);
    }
}

static void find_residual(grid *g) {
    uint32_t w = g->x.size;
    for (uint32_t y = 1; y + 1 < g->y.size; y++) {
        float *r = g->r + (size_t)y * w;
        find_rest(g, y);
        for (uint32_t x = 1; x + 1 < w; x++)
            r[x] = -g->line[x];
    }
}

/* ---- between grids ---------------------------------------------------------------------------------------- */

/* The fine residual becomes the coarse right side. */
static void restrict_residual(const grid *fine, grid *coarse) {
    uint32_t fw = fine->x.size, cw = coarse->x.size;
    for (uint32_t y = 1; y + 1 < coarse->y.size; y++) {
        uint32_t m = fine_line(&fine->y, &coarse->y, y);
        const float *row = fine->r + (size_t)m * fw, *up = row - fw, *down = row + fw;
        float a = coarse->y.left[y], b = coarse->y.centre[y], c = coarse->y.right[y];
        float *line = fine->line, *out = coarse->f + (size_t)y * cw;
        for (uint32_t x = 0; x < fw; x++)
            line[x] = a * up[x] + b * row[x] + c * down[x];
        for (uint32_t x = 1; x + 1 < cw; x++) {
            uint32_t k = fine_line(&fine->x, &coarse->x, x);
            out[x] = coarse->x.left[x] * line[k - 1] + coarse->x.centre[x] * line[k] + coarse->x.right[x] * line[k + 1];
        }
    }
}

/* u = keep u + the coarse function, inside. Returns the largest of the latter. */
static float interpolate(grid *fine, const grid *coarse, float keep) {
    uint32_t fw = fine->x.size, cw = coarse->x.size;
    float most = 0.0f;
    for (uint32_t y = 1; y + 1 < fine->y.size; y++) {
        uint32_t c = fine->y.coarse[y];
        float s = fine->y.share[y];
        const float *a = coarse->u + (size_t)c * cw, *b = s > 0.0f ? a + cw : a;
        float *row = fine->u + (size_t)y * fw;
        float *line = coarse->line;
        for (uint32_t x = 0; x < cw; x++)
            line[x] = a[x] + s * (b[x] - a[x]);
        for (uint32_t x = 1; x + 1 < fw; x++) {
            uint32_t k = fine->x.coarse[x];
            float t = fine->x.share[x];
            float value = t > 0.0f ? line[k] + t * (line[k + 1] - line[k]) : line[k];
            row[x] = keep * row[x] + value;
            most = fmaxf(most, fabsf(value));
        }
    }
    return most;
}

/* One V cycle: what is left, f - star u, is the right side of the coarser grid's correction. Returns the largest
 * correction. */
static float cycle(pyramid *p, int level) {
    grid *g = &p->grids[level];
    if (level + 1 == p->count) {
        relax_both(g, 4 * COARSEST * COARSEST);
        return 0.0f;
    }
    grid *coarse = &p->grids[level + 1];
    relax_both(g, 2);
    find_residual(g);
    restrict_residual(g, coarse);
    memset(coarse->u, 0, (size_t)coarse->x.size * coarse->y.size * sizeof(float));
    cycle(p, level + 1);
    float most = interpolate(g, coarse, 1.0f);
    relax_both(g, 2);
    return most;
}

static void take_border(const grid *fine, grid *coarse) {
    uint32_t w = coarse->x.size, h = coarse->y.size;
    for (uint32_t y = 0; y < h; y++) {
        const float *row = fine->u + (size_t)fine_line(&fine->y, &coarse->y, y) * fine->x.size;
        uint32_t step = y == 0 || y + 1 == h ? 1 : w - 1;
        for (uint32_t x = 0; x < w; x += step)
            coarse->u[(size_t)y * w + x] = row[fine_line(&fine->x, &coarse->x, x)];
    }
    memset(coarse->f, 0, (size_t)w * h * sizeof(float));
}

static float border_range(const grid *g) {
    uint32_t w = g->x.size, h = g->y.size;
    float least = g->u[0], most = g->u[0];
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x += y == 0 || y + 1 == h ? 1 : w - 1) {
            least = fminf(least, g->u[(size_t)y * w + x]);
            most = fmaxf(most, g->u[(size_t)y * w + x]);
        }
    return most - least;
}

static void solve(pyramid *p) {
    float enough = ENOUGH * border_range(&p->grids[0]);
    for (int level = 1; level < p->count; level++)
        take_border(&p->grids[level - 1], &p->grids[level]);
    for (int level = p->count - 1; level >= 0; level--) {
        if (level + 1 < p->count)
            interpolate(&p->grids[level], &p->grids[level + 1], 0.0f);
        int cycles = level > 0 ? 2 : MOST_CYCLES;
        for (int i = 0; i < cycles; i++)
            if (cycle(p, level) <= enough && level == 0)
                break;
    }
}

/* ---- planes ----------------------------------------------------------------------------------------------- */

typedef struct plane_work {
    float *const *planes;
    uint32_t width, height;
} plane_work;

static author_result fill_plane(void *context, size_t index, unsigned worker, char *error) {
    const plane_work *work = context;
    (void)worker;
    (void)error;
    if (work->width < 3 || work->height < 3)
        return AUTHOR_OK; /* nothing but border */
    pyramid *p = calloc(1, sizeof *p);
    int made = p && make_pyramid(p, work->planes[index], work->width, work->height);
    if (made)
        solve(p);
    for (int i = 0; p && i < p->block_count; i++)
        free(p->blocks[i]);
    free(p);
    return made ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

author_result author_harmonic(author_run *run, float *const *planes, size_t count, uint32_t width, uint32_t height) {
    plane_work work = {planes, width, height};
    author_result result = author_for(run, "colours", count, fill_plane, &work);
    return result == AUTHOR_NO_MEMORY ? author_fail(run, result, "no memory for the colours of a patch of %u x %u",
                                                    (unsigned)width, (unsigned)height)
                                      : result;
}

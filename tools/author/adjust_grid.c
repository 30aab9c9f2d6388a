/* SPDX-License-Identifier: Apache-2.0 */
/* Patch and ground, both averaged over cells of about a texel of the ground and then smoothed alike. */
#include "adjust_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FEWEST_CELLS 3
#define KNOWN 0.25f /* of a cell's neighbourhood, smoothed */
#define AROUND 2    /* cells */

void adjust_planes_release(author_planes *planes) {
    for (int c = 0; c < 3; c++)
        free(planes->planes[c]);
    *planes = (author_planes){{0}};
}

author_result adjust_planes_create(author_run *run, const author_grid *grid, author_planes *out) {
    *out = (author_planes){{0}};
    for (uint32_t c = 0; c < grid->channels; c++) {
        out->planes[c] = author_alloc(run, (size_t)grid->width * grid->height, sizeof(float));
        if (!out->planes[c]) {
            adjust_planes_release(out);
            return AUTHOR_NO_MEMORY;
        }
    }
    return AUTHOR_OK;
}

void adjust_grid_release(author_grid *grid) {
    for (int c = 0; c < 3; c++) {
        free(grid->patch[c]);
        free(grid->ground[c]);
        free(grid->change[c]);
        free(grid->clipped[c]);
        free(grid->cut[c]);
    }
    free(grid->valid);
    *grid = (author_grid){0};
}

/* ---- how large a cell is --------------------------------------------------------------------------------- */

/* Texels of the patch along one of the ground, the largest of its corners and centre. -1: no inverse. */
static int texel_sizes(const author_picture *patch, const author_ground *ground, double size[2]) {
    static const double places[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};
    double back[9], at[2], j[4];
    if (adjust_invert(ground->matrix, back))
        return -1;
    size[0] = size[1] = 1.0;
    for (int i = 0; i < 5; i++) {
        if (adjust_apply(back, places[i][0], places[i][1], at))
            continue;
        adjust_jacobian(back, places[i][0], places[i][1], j);
        double gw = ground->picture->width, gh = ground->picture->height;
        double x = adjust_length(j[0] * gw, j[2] * gh) / patch->width,
               y = adjust_length(j[1] * gw, j[3] * gh) / patch->height;
        size[0] = fmax(size[0], 1.0 / fmax(x, 1e-9));
        size[1] = fmax(size[1], 1.0 / fmax(y, 1e-9));
    }
    return 0;
}

static uint32_t cells_of(uint32_t texels, double size) {
    double cells = floor(texels / size + 0.5);
    return (uint32_t)fmin(fmax(cells, FEWEST_CELLS), ADJUST_MOST_CELLS);
}

/* ---- the patch's means ------------------------------------------------------------------------------------- */

typedef struct filling {
    const author_picture *patch;
    const author_ground *ground;
    author_grid *grid;
    float *weight;      /* how much of each cell is there: of the patch, then of both */
    float *sums;        /* scratch of each worker: cells of a row, colours and weight */
    double back[9];     /* of the ground at hand */
    uint8_t *from_here; /* cells that have their ground */
} filling;

/* One row of texels into the sums, each texel shared by the cells that it touches: colours, how far they are clipped,
 * weight. */
static void add_row(const filling *f, const float *row, float part, float *sums) {
    uint32_t texels = f->patch->width, channels = f->patch->channels, colours = f->grid->channels;
    uint32_t cells = f->grid->width, stride = 2 * colours + 1;
    double step = (double)cells / texels;
    for (uint32_t x = 0; x < texels; x++) {
        double from = x * step, to = from + step;
        const float *texel = row + (size_t)x * channels;
        float alpha = colours < channels ? texel[channels - 1] : 1.0f;
        for (uint32_t cell = (uint32_t)from; cell < cells && cell < to; cell++) {
            double begin = fmax(from, cell), end = fmin(to, cell + 1.0);
            float w = (float)(end - begin) * part * alpha;
            float *sum = sums + (size_t)cell * stride;
            for (uint32_t c = 0; c < colours; c++) {
                sum[c] += w * texel[c];
                sum[colours + c] += w * adjust_clipping(texel[c]);
            }
            sum[2 * colours] += w;
        }
    }
}

static author_result average_row(void *context, size_t index, unsigned worker, char *error) {
    const filling *f = context;
    const author_grid *g = f->grid;
    (void)error;
    uint32_t stride = 2 * g->channels + 1, texels = f->patch->height;
    float *sums = f->sums + (size_t)worker * g->width * stride;
    double step = (double)texels / g->height, from = (double)index * step, to = from + step;
    memset(sums, 0, (size_t)g->width * stride * sizeof *sums);
    for (uint32_t y = (uint32_t)from; y < texels && y < to; y++) {
        double part = (fmin(to, y + 1.0) - fmax(from, y)) / step;
        add_row(f, f->patch->texels + (size_t)y * f->patch->width * f->patch->channels, (float)part, sums);
    }
    for (uint32_t x = 0; x < g->width; x++) {
        size_t cell = index * g->width + x;
        const float *sum = sums + (size_t)x * stride;
        float weight = sum[2 * g->channels];
        f->weight[cell] = weight;
        for (uint32_t c = 0; c < g->channels && weight > 0.0f; c++) {
            g->patch[c][cell] = sum[c] / weight;
            g->clipped[c][cell] = sum[g->channels + c] / weight;
        }
    }
    return AUTHOR_OK;
}

/* ---- the ground ------------------------------------------------------------------------------------------------ */

/* Where the ground ends, its texels at the edge still have their whole neighbourhood only half a texel inside. */
static int is_inside(const double at[2]) {
    return at[0] >= 0.0 && at[0] <= 1.0 && at[1] >= 0.0 && at[1] <= 1.0;
}

static void look_up(const filling *f, size_t cell, double x, double y, uint32_t probes) {
    const author_grid *g = f->grid;
    const author_picture *picture = f->ground->picture;
    float sum[4] = {0}, cut[4] = {0}, value[4];
    double at[2];
    for (uint32_t p = 0; p < probes * probes; p++) {
        double px = (x + (p % probes + 0.5) / probes) / g->width, py = (y + (p / probes + 0.5) / probes) / g->height;
        if (adjust_apply(f->back, px, py, at) || !is_inside(at))
            return;
        adjust_sample(picture, at[0] * picture->width, at[1] * picture->height, value);
        for (uint32_t c = 0; c < g->channels; c++) {
            sum[c] += value[c];
            cut[c] += adjust_clipping(value[c]);
        }
    }
    for (uint32_t c = 0; c < g->channels; c++) {
        g->ground[c][cell] = sum[c] / (float)(probes * probes);
        g->cut[c][cell] = cut[c] / (float)(probes * probes);
    }
    f->from_here[cell] = 1;
}

static author_result ground_row(void *context, size_t y, unsigned worker, char *error) {
    const filling *f = context;
    const author_grid *g = f->grid;
    double at[2], j[4];
    (void)worker;
    (void)error;
    for (uint32_t x = 0; x < g->width; x++) {
        size_t cell = y * g->width + x;
        double cx = (x + 0.5) / g->width, cy = ((double)y + 0.5) / g->height;
        if (f->from_here[cell] || adjust_apply(f->back, cx, cy, at))
            continue;
        adjust_jacobian(f->back, cx, cy, j);
        double gw = f->ground->picture->width, gh = f->ground->picture->height;
        double size = fmax(adjust_length(j[0] * gw, j[2] * gh) / g->width,
                           adjust_length(j[1] * gw, j[3] * gh) / g->height);
        look_up(f, cell, x, (double)y, size > 1.0 ? (uint32_t)fmin(ceil(size), 8.0) + 1 : 2);
    }
    return AUTHOR_OK;
}

/* ---- smoothing -------------------------------------------------------------------------------------------------- */

/* Binomial of five along one direction; what lies outside counts as nothing. */
static void smooth_line(const float *from, float *to, uint32_t count, size_t stride) {
    static const float weights[5] = {1.0f / 16, 4.0f / 16, 6.0f / 16, 4.0f / 16, 1.0f / 16};
    for (uint32_t i = 0; i < count; i++) {
        float sum = 0.0f;
        for (uint32_t k = 0; k < 5; k++)
            if (i + k >= 2 && i + k - 2 < count)
                sum += weights[k] * from[(size_t)(i + k - 2) * stride];
        to[(size_t)i * stride] = sum;
    }
}

static void smooth(const author_grid *g, float *plane, float *scratch) {
    for (uint32_t y = 0; y < g->height; y++)
        smooth_line(plane + (size_t)y * g->width, scratch + (size_t)y * g->width, g->width, 1);
    for (uint32_t x = 0; x < g->width; x++)
        smooth_line(scratch + x, plane + x, g->height, g->width);
}

/* Values times weight are smoothed and divided by the smoothed weight, so that what is unknown does not count. */
static author_result smooth_all(author_run *run, filling *f) {
    author_grid *g = f->grid;
    size_t cells = (size_t)g->width * g->height, valid = 0;
    float *scratch = author_alloc(run, cells, sizeof *scratch);
    if (!scratch)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < cells; i++)
        f->weight[i] = f->from_here[i] ? f->weight[i] : 0.0f;
    for (uint32_t k = 0; k < 4 * g->channels; k++) {
        float *const planes[4] = {g->patch[k / 4], g->ground[k / 4], g->clipped[k / 4], g->cut[k / 4]};
        float *plane = planes[k % 4];
        for (size_t i = 0; i < cells; i++)
            plane[i] *= f->weight[i];
        smooth(g, plane, scratch);
    }
    smooth(g, f->weight, scratch);
    for (size_t i = 0; i < cells; i++) {
        g->valid[i] = f->weight[i] > KNOWN;
        valid += g->valid[i];
        for (uint32_t c = 0; c < g->channels && g->valid[i]; c++) {
            g->patch[c][i] /= f->weight[i];
            g->ground[c][i] /= f->weight[i];
            g->clipped[c][i] /= f->weight[i];
            g->cut[c][i] /= f->weight[i];
        }
    }
    g->covered = (double)valid / (double)cells;
    free(scratch);
    return AUTHOR_OK;
}

/* ---- where the ground is busy -------------------------------------------------------------------------------- */

/* Least and most of the known cells up to AROUND away, of which there is one. */
static float range_around(const author_grid *g, const float *plane, uint32_t x, uint32_t y) {
    uint32_t x0 = x < AROUND ? 0 : x - AROUND, x1 = x + AROUND < g->width ? x + AROUND : g->width - 1;
    uint32_t y0 = y < AROUND ? 0 : y - AROUND, y1 = y + AROUND < g->height ? y + AROUND : g->height - 1;
    float low = HUGE_VALF, high = -HUGE_VALF;
    for (uint32_t j = y0; j <= y1; j++)
        for (uint32_t i = x0; i <= x1; i++) {
            size_t cell = (size_t)j * g->width + i;
            low = g->valid[cell] ? fminf(low, plane[cell]) : low;
            high = g->valid[cell] ? fmaxf(high, plane[cell]) : high;
        }
    return high - low;
}

static author_result change_row(void *context, size_t y, unsigned worker, char *error) {
    const author_grid *g = context;
    (void)worker;
    (void)error;
    for (uint32_t c = 0; c < g->channels; c++)
        for (uint32_t x = 0; x < g->width; x++) {
            size_t cell = y * g->width + x;
            if (g->valid[cell])
                g->change[c][cell] = range_around(g, g->ground[c], x, (uint32_t)y) / (2 * AROUND);
        }
    return AUTHOR_OK;
}

/* ---- all of it ----------------------------------------------------------------------------------------------- */

static author_result fill_grid(author_run *run, filling *f, const author_ground *grounds, size_t count) {
    author_result result = author_for(run, "colours", f->grid->height, average_row, f);
    for (size_t i = 0; i < count && result == AUTHOR_OK; i++) {
        f->ground = &grounds[i];
        if (adjust_invert(grounds[i].matrix, f->back))
            return author_fail(run, AUTHOR_BAD_INPUT, "the placement cannot be inverted");
        result = author_for(run, "colours", f->grid->height, ground_row, f);
    }
    if (result == AUTHOR_OK)
        result = smooth_all(run, f);
    return result == AUTHOR_OK ? author_for(run, "colours", f->grid->height, change_row, f->grid) : result;
}

static author_result allocate(author_run *run, author_grid *g) {
    size_t cells = (size_t)g->width * g->height;
    int made = (g->valid = author_alloc(run, cells, 1)) != NULL;
    for (uint32_t c = 0; c < g->channels; c++) {
        made = made && (g->patch[c] = author_alloc(run, cells, sizeof(float))) != NULL;
        made = made && (g->ground[c] = author_alloc(run, cells, sizeof(float))) != NULL;
        made = made && (g->change[c] = author_alloc(run, cells, sizeof(float))) != NULL;
        made = made && (g->clipped[c] = author_alloc(run, cells, sizeof(float))) != NULL;
        made = made && (g->cut[c] = author_alloc(run, cells, sizeof(float))) != NULL;
    }
    return made ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* A picture with values far above 1 is no photograph of a camera that ends there. */
static void forget_clipping(author_grid *g, const author_picture *patch) {
    uint32_t channels = patch->channels;
    size_t texels = (size_t)patch->width * patch->height;
    float most = 0.0f;
    for (size_t i = 0; i < texels; i++)
        for (uint32_t c = 0; c < g->channels; c++)
            most = fmaxf(most, patch->texels[i * channels + c]);
    for (uint32_t c = 0; c < g->channels && most > 1.01f; c++) {
        memset(g->clipped[c], 0, (size_t)g->width * g->height * sizeof(float));
        memset(g->cut[c], 0, (size_t)g->width * g->height * sizeof(float));
    }
    g->bounded = most <= 1.01f;
}

author_result adjust_grid_create(author_run *run, const author_picture *patch, const author_ground *grounds,
                                 size_t count, author_grid *out) {
    double size[2] = {1.0, 1.0};
    *out = (author_grid){.channels = adjust_colours(patch)};
    for (size_t i = 0; i < count; i++)
        if (adjust_colours(grounds[i].picture) != out->channels)
            return author_fail(run, AUTHOR_BAD_INPUT, "a patch of %u channels cannot take colours of %u",
                               (unsigned)out->channels, (unsigned)adjust_colours(grounds[i].picture));
    if (count && texel_sizes(patch, &grounds[0], size))
        return author_fail(run, AUTHOR_BAD_INPUT, "the placement cannot be inverted");
    out->width = cells_of(patch->width, size[0]);
    out->height = cells_of(patch->height, size[1]);
    size_t cells = (size_t)out->width * out->height;
    author_result result = allocate(run, out);
    filling f = {.patch = patch, .grid = out};
    f.weight = author_alloc(run, cells, sizeof *f.weight);
    f.from_here = author_alloc(run, cells, 1);
    f.sums = author_alloc(run, (size_t)author_workers(run) * out->width * (2 * out->channels + 1), sizeof *f.sums);
    if (result == AUTHOR_OK && f.weight && f.from_here && f.sums)
        result = fill_grid(run, &f, grounds, count);
    else
        result = AUTHOR_NO_MEMORY;
    free(f.weight);
    free(f.from_here);
    free(f.sums);
    if (result == AUTHOR_OK)
        forget_clipping(out, patch);
    if (result != AUTHOR_OK)
        adjust_grid_release(out);
    return result;
}

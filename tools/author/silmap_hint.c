/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a drawing best lies in its texture. Points stand on (k + 1/2) / 8 of a cell. A slanted edge passes near enough points to be held well
 * wherever it is, but one along an axis that lies between two lines of points is off by up to a 16th of a cell for all of its
 * length. So the edges along the axes are gathered from the picture, by where they are, and each side of the drawing goes out
 * by as much as puts most of their length on lines of points. The two axes have nothing to do with each other.
 */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

#define REACH 0.5 /* cells that a side may go out */
#define BINS 512  /* of a cell: positions that are told apart */
#define STEPS 32  /* of a side, first; then some more around the best */
#define FINER 4   /* times, for each search after the first */
#define SEARCHES 3
#define SLOPE (1.0 / 16)  /* up to which an edge counts as along an axis */
#define CONTRAST 0.01f    /* squared, of a step that counts */
#define SAME (6.0f / 255) /* apart are texels of one colour, at most */
#define WORTH 0.95        /* of the cost where the drawing is, or it stays there */
#define LATTICE (1.0 / 8)

typedef struct place_weight {
    double at, weight; /* in cells; length times contrast */
} place_weight;

typedef struct hint_job {
    const author_picture *picture;
    silmap_curve curve;
    uint32_t cells[2];
    double *bins;
    double *last; /* for each position along the axis: where the edge was in the line before; below 0: there was none */
    place_weight *places;
    size_t count;
} hint_job;

/* ---- edges ---------------------------------------------------------------------------------------------- */

static void coded_at(const hint_job *job, size_t index, float out[SILMAP_CHANNELS]) {
    silmap_texel(job->picture, &job->curve, index, out);
    for (uint32_t ch = 0; ch < job->picture->channels; ch++)
        out[ch] = silmap_code(&job->curve, ch, out[ch]);
}

static int is_same(const hint_job *job, size_t index, const float *coded) {
    float other[SILMAP_CHANNELS];
    coded_at(job, index, other);
    for (uint32_t ch = 0; ch < job->picture->channels; ch++)
        if (!(fabsf(other[ch] - coded[ch]) <= SAME))
            return 0;
    return 1;
}

/* Whether texel number `along` of a line is a step from one flat colour to another. *share is how much of it has the colour before. */
static int is_step(const hint_job *job, size_t index, size_t step, size_t along, size_t n, double *share,
                   float *contrast) {
    uint32_t channels = job->picture->channels;
    const float *texels = job->picture->texels;
    if (along < 1 || along + 1 >= n ||
        memcmp(texels + (index - step) * channels, texels + (index + step) * channels, channels * sizeof *texels) == 0)
        return 0;
    float before[SILMAP_CHANNELS], own[SILMAP_CHANNELS], after[SILMAP_CHANNELS], product = 0;
    coded_at(job, index - step, before);
    coded_at(job, index, own);
    coded_at(job, index + step, after);
    *contrast = 0;
    for (uint32_t ch = 0; ch < channels; ch++) {
        float d = before[ch] - after[ch];
        *contrast += d * d;
        product += d * (own[ch] - after[ch]);
    }
    *share = *contrast > CONTRAST ? (double)(product / *contrast) : 0;
    if (!(*share > 0 && *share <= 1))
        return 0;
    for (uint32_t ch = 0; ch < channels; ch++)
        if (fabs((double)(own[ch] - after[ch]) - *share * (double)(before[ch] - after[ch])) > (double)SAME)
            return 0;
    return (along < 2 || is_same(job, index - 2 * step, before)) &&
           (along + 2 >= n || is_same(job, index + 2 * step, after));
}

/* Edges across an axis: 0 those whose x is one, 1 those whose y is. */
static void gather(hint_job *job, int axis) {
    uint32_t w = job->picture->width, h = job->picture->height;
    size_t n = axis ? h : w, step = axis ? w : 1;
    double scale = (double)job->cells[axis] / (double)n, most = (double)job->cells[axis] * BINS - 1;
    memset(job->bins, 0, (size_t)job->cells[axis] * BINS * sizeof *job->bins);
    for (size_t i = 0; i < n; i++)
        job->last[i] = -1;
    for (size_t index = 0; index < (size_t)w * h; index++) {
        size_t along = axis ? index / w : index % w;
        double share, before = axis && index % w == 0 ? -1 : job->last[along], *last = &job->last[along];
        float contrast;
        *last = -1;
        if (!is_step(job, index, step, along, n, &share, &contrast))
            continue;
        *last = (double)along + share;
        if (before >= 0 && fabs(*last - before) <= SLOPE)
            job->bins[(size_t)fmin((*last + before) / 2 * scale * BINS, most)] += (double)contrast;
    }
    job->count = 0;
    for (size_t i = 0; i < (size_t)job->cells[axis] * BINS; i++)
        if (job->bins[i] > 0)
            job->places[job->count++] = (place_weight){((double)i + 0.5) / BINS, job->bins[i]};
}

/* ---- the best place ------------------------------------------------------------------------------------- */

/* Of an edge, by its length: it lies on one line of points, or goes to and fro between two. */
static double edge_cost(double at) {
    double t = at / LATTICE - 0.5, off = fabs(t - floor(t + 0.5)) * LATTICE, rest = LATTICE - off;
    return fmin(off, (off * off + rest * rest) / (2 * LATTICE));
}

/* The drawing's sides at -out[0] and cells + out[1]. */
static double cost_of(const hint_job *job, double cells, const double out[2]) {
    double scale = (cells + out[0] + out[1]) / cells, sum = 0;
    for (size_t i = 0; i < job->count; i++)
        sum += job->places[i].weight * edge_cost(job->places[i].at * scale - out[0]);
    return sum;
}

static void search(const hint_job *job, double cells, double step, int steps, double best[2], double *least) {
    double middle[2] = {best[0], best[1]};
    for (int i = -steps; i <= steps; i++) {
        for (int j = -steps; j <= steps; j++) {
            double out[2] = {middle[0] + i * step, middle[1] + j * step};
            if (out[0] < 0 || out[1] < 0 || out[0] > REACH || out[1] > REACH)
                continue;
            double cost = cost_of(job, cells, out);
            if (cost < *least) {
                *least = cost;
                best[0] = out[0];
                best[1] = out[1];
            }
        }
    }
}

static void place_axis(hint_job *job, int axis, double *start, double *size) {
    double cells = job->cells[axis], best[2] = {0, 0}, step = REACH / STEPS;
    gather(job, axis);
    double before = cost_of(job, cells, best), least = before;
    for (int i = 0; i < SEARCHES; i++, step /= FINER)
        search(job, cells, step, i ? FINER : STEPS, best, &least);
    int worth = least < WORTH * before;
    *start = worth ? 0 - best[0] / cells : 0;
    *size = worth ? (cells + best[0] + best[1]) / cells : 1;
}

int author_silmap_is_moved(const author_silmap_place *place) {
    return place->x < 0 || place->y < 0 || place->width > 1 || place->height > 1;
}

int author_silmap_is_better(const author_silmap_result *fit, const author_silmap_result *other) {
    int two_regions = fit->samples.channels == 1 && other->samples.channels == 1;
    if (two_regions && (fit->disagreement < other->disagreement || fit->disagreement > other->disagreement))
        return fit->disagreement < other->disagreement;
    return fit->psnr > other->psnr;
}

author_result author_silmap_hint(author_run *run, const author_picture *picture, uint32_t cells_x, uint32_t cells_y,
                                 int plain, author_silmap_place *out) {
    *out = (author_silmap_place){0, 0, 1, 1};
    if (picture->channels > SILMAP_CHANNELS || cells_x == 0 || cells_y == 0 || cells_x > picture->width ||
        cells_y > picture->height)
        return author_fail(run, AUTHOR_BAD_INPUT, "%u x %u cells for a picture of %u x %u", cells_x, cells_y,
                           picture->width, picture->height);
    hint_job job = {.picture = picture, .cells = {cells_x, cells_y}};
    size_t longer = picture->width > picture->height ? picture->width : picture->height;
    size_t bins = (size_t)(cells_x > cells_y ? cells_x : cells_y) * BINS;
    silmap_curve_set(&job.curve, picture->channels, plain);
    job.bins = author_alloc(run, bins, sizeof *job.bins);
    job.last = author_alloc(run, longer, sizeof *job.last);
    job.places = author_alloc(run, bins, sizeof *job.places);
    int all = job.bins && job.last && job.places;
    if (all) {
        place_axis(&job, 0, &out->x, &out->width);
        place_axis(&job, 1, &out->y, &out->height);
    }
    free(job.bins);
    free(job.last);
    free(job.places);
    return all ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

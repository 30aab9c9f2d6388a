/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the edges along an axis lie best. Points stand on (k + 1/2) / 8 of a cell. A slanted edge passes near enough
 * points to be held well wherever it is, but one along an axis that lies between two lines of points is off by up to a
 * 16th of a cell for all of its length. So the edges along the axes are gathered from the picture, by where they are,
 * and each side of the drawing goes out by as much as puts most of their length on lines of points.
 */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

#define BINS 512 /* of a cell: positions that are told apart */
#define STEPS 32 /* of a side, first; then some more around the best */
#define FINER 4  /* times, for each search after the first */
#define SEARCHES 2
#define SLOPE (1.0 / 16)  /* up to which an edge counts as along an axis */
#define CONTRAST 0.01f    /* squared, of a step that counts */
#define SAME (6.0f / 255) /* apart are texels of one colour, at most */
#define APART (1.0 / 16)  /* one side of two spots, at least */
#define LATTICE (1.0 / 8)

typedef struct place_weight {
    double at, weight; /* in cells; length times contrast */
} place_weight;

typedef struct axis_job {
    const author_picture *picture;
    const silmap_curve *curve;
    uint32_t cells; /* along the axis */
    double *bins;
    double *last; /* for each position along the axis: where the edge was in the line before; below 0: there was none */
    place_weight *places;
    size_t count;
} axis_job;

/* ---- edges ---------------------------------------------------------------------------------------------- */

static void coded_at(const axis_job *job, size_t index, float out[SILMAP_CHANNELS]) {
    silmap_texel(job->picture, job->curve, index, out);
    for (uint32_t ch = 0; ch < job->picture->channels; ch++)
        out[ch] = silmap_code(job->curve, ch, out[ch]);
}

static int is_same(const axis_job *job, size_t index, const float *coded) {
    float other[SILMAP_CHANNELS];
    coded_at(job, index, other);
    for (uint32_t ch = 0; ch < job->picture->channels; ch++)
        if (!(fabsf(other[ch] - coded[ch]) <= SAME))
            return 0;
    return 1;
}

/* Whether texel number `along` of a line is a step from one flat colour to another. *share is how much of it has the
 * colour before. */
static int is_step(const axis_job *job, size_t index, size_t step, size_t along, size_t n, double *share,
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
static void gather(axis_job *job, int axis) {
    uint32_t w = job->picture->width, h = job->picture->height;
    size_t n = axis ? h : w, step = axis ? w : 1;
    double scale = (double)job->cells / (double)n, most = (double)job->cells * BINS - 1;
    memset(job->bins, 0, (size_t)job->cells * BINS * sizeof *job->bins);
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
    for (size_t i = 0; i < (size_t)job->cells * BINS; i++)
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
static double cost_of(const axis_job *job, const double out[2]) {
    double cells = job->cells, scale = (cells + out[0] + out[1]) / cells, sum = 0;
    for (size_t i = 0; i < job->count; i++)
        sum += job->places[i].weight * edge_cost(job->places[i].at * scale - out[0]);
    return sum;
}

static void search(const axis_job *job, double step, silmap_spot *best) {
    double middle[2] = {best->out[0], best->out[1]};
    for (int i = -FINER; i <= FINER; i++) {
        for (int j = -FINER; j <= FINER; j++) {
            silmap_spot spot = {{middle[0] + i * step, middle[1] + j * step}, 0};
            if (spot.out[0] < 0 || spot.out[1] < 0 || spot.out[0] > SILMAP_REACH || spot.out[1] > SILMAP_REACH)
                continue;
            spot.cost = cost_of(job, spot.out);
            if (spot.cost < best->cost)
                *best = spot;
        }
    }
}

static int is_apart(const silmap_spot *spot, const silmap_spot *others, int count) {
    for (int i = 0; i < count; i++)
        if (fabs(spot->out[0] - others[i].out[0]) < APART && fabs(spot->out[1] - others[i].out[1]) < APART)
            return 0;
    return 1;
}

static void list_spots(const axis_job *job, silmap_spot out[SILMAP_SPOTS]) {
    silmap_spot all[(STEPS + 1) * (STEPS + 1)];
    int n = (STEPS + 1) * (STEPS + 1), count = 0;
    double step = SILMAP_REACH / STEPS;
    for (int i = 0; i < n; i++) {
        all[i] = (silmap_spot){{i / (STEPS + 1) * step, i % (STEPS + 1) * step}, 0};
        all[i].cost = cost_of(job, all[i].out);
    }
    while (count < SILMAP_SPOTS) {
        const silmap_spot *best = NULL;
        for (int i = 0; i < n; i++)
            if ((!best || all[i].cost < best->cost) && is_apart(&all[i], out, count))
                best = &all[i];
        out[count] = *best;
        for (int k = 0; k < SEARCHES; k++)
            search(job, k ? step / FINER / FINER : step / FINER, &out[count]);
        count++;
    }
}

author_result silmap_axis_spots(author_run *run, const author_picture *picture, const silmap_curve *curve,
                                uint32_t cells, int axis, double *before, silmap_spot out[SILMAP_SPOTS]) {
    static const double nothing[2] = {0, 0};
    axis_job job = {.picture = picture, .curve = curve, .cells = cells};
    size_t bins = (size_t)cells * BINS;
    job.bins = author_alloc(run, bins, sizeof *job.bins);
    job.last = author_alloc(run, axis ? picture->height : picture->width, sizeof *job.last);
    job.places = author_alloc(run, bins, sizeof *job.places);
    int all = job.bins && job.last && job.places;
    if (all) {
        gather(&job, axis);
        *before = cost_of(&job, nothing);
        list_spots(&job, out);
    }
    free(job.bins);
    free(job.last);
    free(job.places);
    return all ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a drawing best lies in its texture. What its edges along the axes say (silmap_axis.c) is a start. Where the
 * regions are known exactly, the points are fitted at some such places, in haste, and around the best of them, and the
 * area that is wrong decides: it knows of slanted edges, of corners and of what is thin.
 */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

#define WORTH 0.95      /* of the cost where the drawing is, or it stays there */
#define PAIRS 16        /* places out of spots that are tried at most, */
#define TRIALS 32       /* and all places; */
#define FEW 80000       /* cells of all trials together */
#define STEP (1.0 / 16) /* of a side, around the best; then less */
#define LEAST (1.0 / 128)

typedef struct hint_job {
    author_run *run;
    const author_run *outer;
    const author_silmap_input *input;
    uint32_t cells[2];
    silmap_truth truth;
    silmap_spot spots[2][SILMAP_SPOTS];
    size_t trials, all; /* that are left, and in all */
    double out[4];      /* the best so far: west, east, north, south */
    double least;
} hint_job;

int author_silmap_is_moved(const author_silmap_place *place) {
    return place->x < 0 || place->y < 0 || place->width > 1 || place->height > 1;
}

int author_silmap_is_better(const author_silmap_result *fit, const author_silmap_result *other) {
    int two_regions = fit->samples.channels == 1 && other->samples.channels == 1;
    if (two_regions && (fit->disagreement < other->disagreement || fit->disagreement > other->disagreement))
        return fit->disagreement < other->disagreement;
    return fit->psnr > other->psnr;
}

/* By trials: the loops of each would go back. */
static int report(void *user, const char *stage, double done) {
    const hint_job *job = user;
    (void)stage, (void)done;
    double share = job->all ? 1 - (double)job->trials / (double)job->all : 0;
    return job->outer->progress(job->outer->user, "place", share);
}

static author_silmap_place place_of(const hint_job *job, const double out[4]) {
    double w = job->cells[0], h = job->cells[1];
    return (author_silmap_place){0 - out[0] / w, 0 - out[2] / h, (w + out[0] + out[1]) / w, (h + out[2] + out[3]) / h};
}

/* ---- by trial ------------------------------------------------------------------------------------------- */

/* Fits the points at a place; keeps it if it is the best. *cells, unless NULL: how many there are to be fitted. */
static author_result try_place(hint_job *job, const double out[4], size_t *cells) {
    author_silmap_place place = place_of(job, out);
    silmap_grid grid;
    silmap_labels labels = {0};
    double cost = 0;
    author_result result = silmap_grid_create(job->run, job->input, job->cells[0], job->cells[1], &grid);
    if (result == AUTHOR_OK)
        result = silmap_labels_create(job->run, &job->truth, &place, 1, &grid, &labels);
    if (result == AUTHOR_OK)
        result = silmap_points_fit(job->run, &labels, 1);
    if (result == AUTHOR_OK)
        result = silmap_labels_judge(job->run, &labels, ZT_SILMAP_NEAREST, 1, &cost, NULL);
    if (result == AUTHOR_OK && cost < job->least) {
        job->least = cost;
        memmove(job->out, out, sizeof job->out);
    }
    if (cells)
        *cells = labels.active_count;
    silmap_labels_release(&labels);
    silmap_grid_release(&grid);
    return result;
}

static int compare_costs(const void *a, const void *b) {
    const silmap_spot *x = a, *y = b;
    return (x->cost > y->cost) - (x->cost < y->cost);
}

/* Spots of both axes, the cheapest pairs first. */
static author_result try_pairs(hint_job *job) {
    silmap_spot pairs[SILMAP_SPOTS * SILMAP_SPOTS];
    int count = SILMAP_SPOTS * SILMAP_SPOTS;
    for (int i = 0; i < count; i++) {
        int x = i % SILMAP_SPOTS, y = i / SILMAP_SPOTS;
        /* The numbers of both, to find them again; and no two costs are equal. */
        pairs[i] = (silmap_spot){{x, y}, job->spots[0][x].cost + job->spots[1][y].cost + i * 1e-9};
    }
    qsort(pairs, (size_t)count, sizeof *pairs, compare_costs);
    author_result result = AUTHOR_OK;
    for (int i = 0; i < PAIRS && job->trials && result == AUTHOR_OK; i++, job->trials--) {
        const double *x = job->spots[0][(int)pairs[i].out[0]].out, *y = job->spots[1][(int)pairs[i].out[1]].out;
        double out[4] = {x[0], x[1], y[0], y[1]};
        result = try_place(job, out, NULL);
    }
    return result;
}

/* One side at a time. */
static author_result try_around(hint_job *job) {
    author_result result = AUTHOR_OK;
    for (double step = STEP; step >= LEAST && job->trials && result == AUTHOR_OK;) {
        double before = job->least;
        for (int i = 0; i < 8 && job->trials && result == AUTHOR_OK; i++) {
            double out[4];
            memcpy(out, job->out, sizeof out);
            out[i / 2] += i & 1 ? step : -step;
            if (out[i / 2] < 0 || out[i / 2] > SILMAP_REACH)
                continue;
            result = try_place(job, out, NULL);
            job->trials--;
        }
        step = job->least < before ? step : step / 2;
    }
    return result;
}

static author_result try_places(hint_job *job) {
    static const double nothing[4] = {0, 0, 0, 0};
    size_t cells = 0;
    author_result result = try_place(job, nothing, &cells);
    job->trials = cells ? FEW / cells : 0;
    job->all = job->trials = job->trials > TRIALS ? TRIALS : job->trials;
    if (result == AUTHOR_OK)
        result = try_pairs(job);
    return result == AUTHOR_OK ? try_around(job) : result;
}

/* ---- all together --------------------------------------------------------------------------------------- */

/* What the edges along the axes say, if it is worth it. */
static void take_spots(hint_job *job, const double before[2]) {
    for (int axis = 0; axis < 2; axis++) {
        const silmap_spot *best = &job->spots[axis][0];
        for (int i = 1; i < SILMAP_SPOTS; i++)
            best = job->spots[axis][i].cost < best->cost ? &job->spots[axis][i] : best;
        if (best->cost < WORTH * before[axis])
            memcpy(job->out + 2 * axis, best->out, sizeof best->out);
    }
}

author_result author_silmap_hint(author_run *run, const author_silmap_input *input, uint32_t cells_x, uint32_t cells_y,
                                 int plain, author_silmap_place *out) {
    const author_picture *picture = input->picture;
    *out = (author_silmap_place){0, 0, 1, 1};
    if (picture->channels > SILMAP_CHANNELS || cells_x == 0 || cells_y == 0 || cells_x > picture->width ||
        cells_y > picture->height)
        return author_fail(run, AUTHOR_BAD_INPUT, "%u x %u cells for a picture of %u x %u", cells_x, cells_y,
                           picture->width, picture->height);
    author_run own = *run;
    hint_job job = {.run = &own, .outer = run, .input = input, .cells = {cells_x, cells_y}, .least = INFINITY};
    if (run->progress) {
        own.progress = report;
        own.user = &job;
    }
    silmap_curve curve;
    silmap_curve_set(&curve, picture->channels, plain);
    double before[2];
    author_result result = AUTHOR_OK;
    for (int axis = 0; axis < 2 && result == AUTHOR_OK; axis++)
        result = silmap_axis_spots(&own, picture, &curve, job.cells[axis], axis, &before[axis], job.spots[axis]);
    int found = 0;
    if (result == AUTHOR_OK && (input->shape_count || input->path_count))
        result = silmap_truth_create(&own, input, &curve, &job.truth, &found);
    if (result == AUTHOR_OK)
        take_spots(&job, before);
    if (result == AUTHOR_OK && job.truth.edges)
        result = try_places(&job);
    silmap_truth_release(&job.truth);
    if (result == AUTHOR_OK)
        *out = place_of(&job, job.out);
    memcpy(run->error, own.error, sizeof run->error);
    return result;
}

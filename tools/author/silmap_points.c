/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Points and sample regions that make the wrong area small. Points one by one, over all places that a cell has for
 * them; then chains of them (silmap_chain.c); then the regions of samples, for a feature that is thinner than a cell is
 * held if a sample beside it joins it. Every step is taken only if the exact area shrinks.
 */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

#define SWEEPS 12
#define ROUNDS 5 /* of points, chains and samples */
#define LINES 12 /* around the four cells of a sample */
#define LOCAL_SWEEPS 4
#define GAIN 1e-7         /* of a cell's area */
#define WORTH_TRYING 0.02 /* a sample's four cells are wrong by that much together */
#define POINT 0x3fu
#define ANYWHERE 7 /* steps that a point may go */
#define NEARBY 2
#define REGIONS 4 /* tried for a sample */

typedef struct points_job {
    silmap_labels *labels;
    double *memory; /* of each worker: tables of LINES lines */
    size_t per_worker;
    uint32_t *moved; /* of each cell: when it moved last */
    uint32_t now;
    uint32_t since; /* samples are tried again only where something has moved since */
    int rounds;
    uint32_t chained; /* so are chains */
    uint8_t *before;
} points_job;

static void ends_of(const silmap_grid *grid, size_t c, int arm, size_t *first, size_t *second) {
    size_t next = silmap_next(grid, c, arm);
    int back = arm == SILMAP_W || arm == SILMAP_N;
    *first = back ? next : c;
    *second = back ? c : next;
}

/* ---- one point ------------------------------------------------------------------------------------------ */

typedef struct local_line {
    silmap_line line;
    size_t first, second; /* cells */
} local_line;

static double line_cost(const silmap_labels *labels, const local_line *l) {
    const uint8_t *cells = labels->grid->cells;
    unsigned first = l->first == SIZE_MAX ? 0 : cells[l->first] & POINT;
    unsigned second = l->second == SIZE_MAX ? silmap_mirrored(first, l->line.vertical) : cells[l->second] & POINT;
    if (l->first == SIZE_MAX)
        first = silmap_mirrored(second, l->line.vertical);
    return silmap_line_cost(&l->line, labels->edge, first, second);
}

static double lines_cost(const silmap_labels *labels, local_line *const lines[4]) {
    double sum = 0;
    for (int arm = 0; arm < 4; arm++)
        sum += line_cost(labels, lines[arm]);
    return sum;
}

static int near_point(unsigned p, unsigned q, int reach) {
    return abs((int)(p & 7) - (int)(q & 7)) <= reach && abs((int)(p >> 3 & 7) - (int)(q >> 3 & 7)) <= reach;
}

/* Puts the point of cell c where its four lines cost least, within some steps. Returns whether it moved. */
static int best_point(silmap_labels *labels, size_t c, local_line *const lines[4], int reach) {
    uint8_t *cell = &labels->grid->cells[c];
    uint8_t old = *cell, best = old;
    int used = 0;
    for (int arm = 0; arm < 4; arm++)
        used |= lines[arm]->line.used;
    if (!used)
        return 0;
    double least = lines_cost(labels, lines) - GAIN;
    for (unsigned p = 0; p < SILMAP_POSITIONS; p++) {
        if (!near_point(p, old, reach))
            continue;
        *cell = (uint8_t)((old & ~POINT) | p);
        double cost = lines_cost(labels, lines);
        if (cost < least) {
            least = cost;
            best = *cell;
        }
    }
    *cell = best;
    return best != old;
}

static int moved_lately(const points_job *job, size_t c) {
    int lately = job->moved[c] + 1 >= job->now;
    for (int arm = 0; arm < 4; arm++) {
        size_t next = silmap_next(job->labels->grid, c, arm);
        lately = lately || (next != SIZE_MAX && job->moved[next] + 1 >= job->now);
    }
    return lately;
}

static author_result visit_point(void *context, size_t c, unsigned worker) {
    points_job *job = context;
    silmap_labels *labels = job->labels;
    double *memory = job->memory + worker * job->per_worker;
    if (!moved_lately(job, c))
        return AUTHOR_OK;
    local_line lines[4], *list[4];
    for (int arm = 0; arm < 4; arm++) {
        local_line *l = list[arm] = &lines[arm];
        ends_of(labels->grid, c, arm, &l->first, &l->second);
        silmap_line_set(labels, l->first, l->second, arm == SILMAP_N || arm == SILMAP_S, memory, &l->line);
        memory += 2 * silmap_table_size(labels->edge);
    }
    if (best_point(labels, c, list, job->now == 1 ? ANYWHERE : NEARBY))
        job->moved[c] = job->now;
    return AUTHOR_OK;
}

/* Visits all of a list, class after class. */
static author_result in_classes(author_run *run, points_job *job, const size_t *all, size_t count, uint32_t width,
                                uint32_t height, uint32_t apart, silmap_visit visit) {
    size_t *list = author_alloc(run, count, sizeof *list);
    author_result result = list ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    uint32_t classes = SILMAP_CLASSES(apart) * SILMAP_CLASSES(apart);
    for (uint32_t k = 0; k < classes && result == AUTHOR_OK; k++) {
        size_t n = silmap_select(all, count, width, height, apart, k, list);
        result = n ? silmap_each(run, "silhouettes", list, n, visit, job) : AUTHOR_OK;
    }
    free(list);
    return result;
}

static author_result descend(author_run *run, points_job *job) {
    silmap_labels *labels = job->labels;
    author_result result = AUTHOR_OK;
    for (int sweep = 0; sweep < SWEEPS && result == AUTHOR_OK; sweep++) {
        job->now++;
        result = in_classes(run, job, labels->active, labels->active_count, labels->grid->w, labels->grid->h, 2,
                            visit_point);
        size_t moves = 0;
        for (size_t i = 0; i < labels->active_count; i++)
            moves += job->moved[labels->active[i]] == job->now;
        if (!moves)
            break;
    }
    return result;
}

/* ---- one sample ----------------------------------------------------------------------------------------- */

/* The four cells around a sample, and the lines that end in them. */
typedef struct surrounding {
    size_t cells[4];
    int count;
    local_line lines[LINES];
    int line_count;
    local_line *of[4][4]; /* by cell and arm */
} surrounding;

static void set_surrounding(points_job *job, size_t s, double *memory, surrounding *out) {
    const silmap_labels *labels = job->labels;
    out->count = out->line_count = 0;
    for (int k = 0; k < 4; k++) {
        size_t c = silmap_cell_of(labels->grid, s, k);
        if (c != SIZE_MAX)
            out->cells[out->count++] = c;
    }
    for (int k = 0; k < out->count; k++) {
        for (int arm = 0; arm < 4; arm++) {
            size_t first, second;
            int vertical = arm == SILMAP_N || arm == SILMAP_S;
            ends_of(labels->grid, out->cells[k], arm, &first, &second);
            int i = 0;
            while (i < out->line_count && (out->lines[i].first != first || out->lines[i].second != second ||
                                           out->lines[i].line.vertical != vertical))
                i++;
            local_line *l = out->of[k][arm] = &out->lines[i];
            if (i < out->line_count)
                continue;
            out->line_count++;
            l->first = first;
            l->second = second;
            silmap_line_set(labels, first, second, vertical, memory, &l->line);
            memory += 2 * silmap_table_size(labels->edge);
        }
    }
}

static double surrounding_cost(const silmap_labels *labels, const surrounding *around) {
    double sum = 0;
    for (int k = 0; k < around->count; k++)
        sum += silmap_base_cost(labels, around->cells[k]);
    for (int i = 0; i < around->line_count; i++)
        sum += line_cost(labels, &around->lines[i]);
    return sum;
}

/* What the four cells alone show wrongly: the halves of the outer lines that are in them. */
static double inner_cost(const silmap_labels *labels, const surrounding *around) {
    double sum = 0;
    for (int k = 0; k < around->count; k++) {
        sum += silmap_base_cost(labels, around->cells[k]);
        for (int arm = 0; arm < 4; arm++) {
            local_line half = *around->of[k][arm];
            if (arm == SILMAP_W || arm == SILMAP_N)
                half.line.first.used = 0;
            else
                half.line.second.used = 0;
            sum += line_cost(labels, &half);
        }
    }
    return sum;
}

static void settle(silmap_labels *labels, surrounding *around) {
    for (int sweep = 0; sweep < LOCAL_SWEEPS; sweep++) {
        int moved = 0;
        for (int k = 0; k < around->count; k++)
            moved |= best_point(labels, around->cells[k], around->of[k], sweep ? NEARBY : ANYWHERE);
        if (!moved)
            break;
    }
}

static int list_regions(const silmap_labels *labels, const surrounding *around, uint32_t own, uint32_t *out) {
    int count = 0;
    for (int k = 0; k < around->count; k++) {
        const silmap_block *block = labels->blocks[around->cells[k]];
        uint32_t regions = block ? block->count : 1;
        for (uint32_t r = 0; r < regions; r++) {
            uint32_t region = block ? block->regions[r] : labels->uniform[around->cells[k]];
            int i = 0;
            while (i < count && out[i] != region)
                i++;
            if (i == count && count < REGIONS && region != own)
                out[count++] = region;
        }
    }
    return count;
}

static void take_points(silmap_grid *grid, const surrounding *around, uint8_t points[4], int restore) {
    for (int k = 0; k < around->count; k++) {
        if (restore)
            grid->cells[around->cells[k]] = points[k];
        else
            points[k] = grid->cells[around->cells[k]];
    }
}

static int any_moved(const points_job *job, const surrounding *around) {
    int moved = 0;
    for (int i = 0; i < around->line_count; i++) {
        const local_line *l = &around->lines[i];
        moved |= l->first != SIZE_MAX && job->moved[l->first] >= job->since;
        moved |= l->second != SIZE_MAX && job->moved[l->second] >= job->since;
    }
    return moved;
}

/* Tries the other regions nearby for a sample, each with the best points that the four cells then have. */
static author_result visit_sample(void *context, size_t s, unsigned worker) {
    points_job *job = context;
    silmap_labels *labels = job->labels;
    double *memory = job->memory + worker * job->per_worker;
    surrounding around;
    set_surrounding(job, s, memory, &around);
    if (!any_moved(job, &around) || inner_cost(labels, &around) < WORTH_TRYING)
        return AUTHOR_OK;
    double least = surrounding_cost(labels, &around) - GAIN;
    uint32_t regions[REGIONS], best = labels->sample[s];
    int count = list_regions(labels, &around, best, regions);
    uint32_t old = best;
    uint8_t start[4], points[4];
    take_points(labels->grid, &around, start, 0);
    take_points(labels->grid, &around, points, 0);
    for (int i = 0; i < count; i++) {
        labels->sample[s] = regions[i];
        take_points(labels->grid, &around, start, 1);
        set_surrounding(job, s, memory, &around);
        settle(labels, &around);
        double cost = surrounding_cost(labels, &around);
        if (cost < least) {
            least = cost;
            best = regions[i];
            take_points(labels->grid, &around, points, 0);
        }
    }
    labels->sample[s] = best;
    take_points(labels->grid, &around, points, 1);
    for (int k = 0; k < around.count; k++)
        if (best != old || points[k] != start[k])
            job->moved[around.cells[k]] = job->now;
    return AUTHOR_OK;
}

/* A sample is in the reach of the fit if all its cells are. */
static int all_active(const silmap_grid *grid, size_t s, uint8_t active) {
    for (int k = 0; k < 4; k++)
        active = (uint8_t)(active - (silmap_cell_of(grid, s, k) != SIZE_MAX));
    return active == 0;
}

static author_result move_samples(author_run *run, points_job *job) {
    silmap_labels *labels = job->labels;
    const silmap_grid *grid = labels->grid;
    size_t samples = (size_t)grid->sw * grid->sh, count = 0;
    uint8_t *near = author_alloc(run, samples, 1);
    size_t *list = author_alloc(run, samples, sizeof *list);
    author_result result = near && list ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (size_t i = 0; result == AUTHOR_OK && i < labels->active_count; i++)
        for (int k = 0; k < 4; k++)
            near[silmap_corner(grid, labels->active[i], k)]++;
    for (size_t s = 0; result == AUTHOR_OK && s < samples; s++)
        if (near[s] && all_active(grid, s, near[s]))
            list[count++] = s;
    if (result == AUTHOR_OK)
        result = in_classes(run, job, list, count, grid->sw, grid->sh, 3, visit_sample);
    free(near);
    free(list);
    return result;
}

/* ---- all together --------------------------------------------------------------------------------------- */

static void start_points(silmap_labels *labels) {
    for (size_t i = 0; i < labels->active_count; i++) {
        const silmap_block *block = labels->blocks[labels->active[i]];
        if (block)
            labels->grid->cells[labels->active[i]] = block->middle;
    }
}

static void cut_by_regions(silmap_labels *labels) {
    silmap_grid *grid = labels->grid;
    for (size_t i = 0; i < labels->active_count; i++) {
        size_t c = labels->active[i];
        uint32_t at[4];
        for (int k = 0; k < 4; k++)
            at[k] = labels->sample[silmap_corner(grid, c, k)];
        silmap_set_cut(grid, c, SILMAP_W, at[ZT_SILMAP_00] != at[ZT_SILMAP_01]);
        silmap_set_cut(grid, c, SILMAP_N, at[ZT_SILMAP_00] != at[ZT_SILMAP_10]);
        silmap_set_cut(grid, c, SILMAP_E, at[ZT_SILMAP_10] != at[ZT_SILMAP_11]);
        silmap_set_cut(grid, c, SILMAP_S, at[ZT_SILMAP_01] != at[ZT_SILMAP_11]);
    }
    silmap_normalise(grid);
}

static author_result fit_chains(author_run *run, points_job *job) {
    const silmap_labels *labels = job->labels;
    memcpy(job->before, labels->grid->cells, (size_t)labels->grid->w * labels->grid->h);
    author_result result = silmap_chains_fit(run, job->labels, job->moved, job->chained);
    job->chained = ++job->now;
    for (size_t i = 0; i < labels->active_count; i++)
        if (labels->grid->cells[labels->active[i]] != job->before[labels->active[i]])
            job->moved[labels->active[i]] = job->now;
    return result;
}

static author_result improve(author_run *run, points_job *job) {
    const silmap_grid *grid = job->labels->grid;
    /* A sample's cells must not meet around the end. */
    int roomy = (!grid->repeat_x || grid->w > 3) && (!grid->repeat_y || grid->h > 3);
    author_result result = descend(run, job);
    for (int round = 0; round < job->rounds && result == AUTHOR_OK; round++) {
        uint32_t start = ++job->now;
        if (roomy)
            result = move_samples(run, job);
        job->since = start;
        if (result == AUTHOR_OK)
            result = descend(run, job);
        if (result == AUTHOR_OK)
            result = fit_chains(run, job);
    }
    return result == AUTHOR_OK ? descend(run, job) : result;
}

author_result silmap_points_fit(author_run *run, silmap_labels *labels, int hasty) {
    points_job job = {.labels = labels};
    job.per_worker = LINES * 2 * silmap_table_size(labels->edge);
    job.memory = author_alloc(run, job.per_worker * author_workers(run), sizeof *job.memory);
    job.moved = author_alloc(run, (size_t)labels->grid->w * labels->grid->h, sizeof *job.moved);
    job.before = author_alloc(run, (size_t)labels->grid->w * labels->grid->h, 1);
    author_result result = job.memory && job.moved && job.before ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    job.rounds = hasty ? 1 : ROUNDS;
    if (result == AUTHOR_OK) {
        start_points(labels);
        result = improve(run, &job);
    }
    if (result == AUTHOR_OK)
        cut_by_regions(labels);
    free(job.memory);
    free(job.moved);
    free(job.before);
    return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Cells, samples and sides of a silmap that is being fitted, and loops over them. */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

#define CHUNK 16    /* indices of one task */
#define SLICE 65536 /* indices between two reports of progress */
#define WORKERS 256

author_result silmap_grid_create(author_run *run, const author_silmap_input *input, uint32_t w, uint32_t h,
                                 silmap_grid *out) {
    *out = (silmap_grid){.w = w, .h = h, .repeat_x = input->repeat_x, .repeat_y = input->repeat_y};
    out->sw = w + !input->repeat_x;
    out->sh = h + !input->repeat_y;
    out->cells = author_alloc(run, (size_t)w * h, 1);
    if (!out->cells)
        return AUTHOR_NO_MEMORY;
    memset(out->cells, ZT_SILMAP_DEFAULT, (size_t)w * h);
    return AUTHOR_OK;
}

void silmap_grid_release(silmap_grid *grid) {
    free(grid->cells);
    *grid = (silmap_grid){0};
}

size_t silmap_next(const silmap_grid *grid, size_t c, int arm) {
    size_t x = c % grid->w, y = c / grid->w;
    if (arm == SILMAP_W)
        return x > 0 ? c - 1 : grid->repeat_x ? c + grid->w - 1 : SIZE_MAX;
    if (arm == SILMAP_E)
        return x + 1 < grid->w ? c + 1 : grid->repeat_x ? c + 1 - grid->w : SIZE_MAX;
    if (arm == SILMAP_N)
        return y > 0 ? c - grid->w : grid->repeat_y ? c + (size_t)(grid->h - 1) * grid->w : SIZE_MAX;
    return y + 1 < grid->h ? c + grid->w : grid->repeat_y ? x : SIZE_MAX;
}

size_t silmap_corner(const silmap_grid *grid, size_t c, int k) {
    size_t y = c / grid->w, x = c - y * grid->w + (size_t)(k & 1);
    y += (size_t)(k >> 1);
    return (y < grid->sh ? y : 0) * grid->sw + (x < grid->sw ? x : 0);
}

/* Coordinate of the cell that has sample i at its far end (behind 1) or at its near one; SIZE_MAX: none. */
static size_t cell_beside(size_t i, int behind, uint32_t cells, int repeat) {
    if (!behind)
        return i < cells ? i : SIZE_MAX;
    return i > 0 ? i - 1 : repeat ? cells - 1 : SIZE_MAX;
}

size_t silmap_cell_of(const silmap_grid *grid, size_t s, int k) {
    size_t j = s / grid->sw;
    size_t x = cell_beside(s - j * grid->sw, k & 1, grid->w, grid->repeat_x);
    size_t y = cell_beside(j, k >> 1, grid->h, grid->repeat_y);
    return x == SIZE_MAX || y == SIZE_MAX ? SIZE_MAX : y * grid->w + x;
}

zt_silmap_cell silmap_look(const silmap_grid *grid, size_t c) {
    zt_silmap_cell cell;
    zt_silmap_cell_at(grid->cells, grid->w, grid->h, grid->repeat_x, grid->repeat_y, (uint32_t)(c % grid->w),
                      (uint32_t)(c / grid->w), &cell);
    return cell;
}

unsigned silmap_cuts(const silmap_grid *grid, size_t c) {
    zt_silmap_cell look = silmap_look(grid, c);
    return ((look.own & ZT_SILMAP_WEST) ? 1u << SILMAP_W : 0) | ((look.own & ZT_SILMAP_NORTH) ? 1u << SILMAP_N : 0) |
           ((look.east & ZT_SILMAP_WEST) ? 1u << SILMAP_E : 0) | ((look.south & ZT_SILMAP_NORTH) ? 1u << SILMAP_S : 0);
}

void silmap_set_cut(silmap_grid *grid, size_t c, int arm, int cut) {
    size_t next = silmap_next(grid, c, arm);
    if (next == SIZE_MAX)
        return;
    size_t owner = arm == SILMAP_W || arm == SILMAP_N ? c : next;
    uint8_t bit = arm == SILMAP_W || arm == SILMAP_E ? ZT_SILMAP_WEST : ZT_SILMAP_NORTH;
    grid->cells[owner] = (uint8_t)(cut ? grid->cells[owner] | bit : grid->cells[owner] & ~bit);
}

size_t silmap_normalise(silmap_grid *grid) {
    size_t cut = 0;
    for (size_t c = 0; c < (size_t)grid->w * grid->h; c++) {
        if (silmap_cuts(grid, c))
            cut++;
        else
            grid->cells[c] = ZT_SILMAP_DEFAULT;
    }
    return cut;
}

uint32_t silmap_class(uint32_t i, uint32_t n, uint32_t apart) {
    uint32_t whole = n - n % apart;
    return i < whole ? i % apart : apart + (i - whole);
}

size_t silmap_select(const size_t *from, size_t count, uint32_t width, uint32_t height, uint32_t apart, uint32_t class,
                     size_t *to) {
    uint32_t classes = SILMAP_CLASSES(apart);
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t x = silmap_class((uint32_t)(from[i] % width), width, apart);
        uint32_t y = silmap_class((uint32_t)(from[i] / width), height, apart);
        if (y * classes + x == class)
            to[n++] = from[i];
    }
    return n;
}

/* ---- loops ---------------------------------------------------------------------------------------------- */

typedef struct each_job {
    const size_t *list;
    size_t first, count;
    silmap_visit visit;
    void *context;
    uint8_t results[WORKERS];
} each_job;

static void each_chunk(void *context, size_t index, unsigned worker) {
    each_job *job = context;
    size_t from = job->first + index * CHUNK;
    size_t to = job->count - from < CHUNK ? job->count : from + CHUNK;
    for (size_t i = from; i < to && job->results[worker] == AUTHOR_OK; i++)
        job->results[worker] = (uint8_t)job->visit(job->context, job->list ? job->list[i] : i, worker);
}

static void each_slice(const author_run *run, each_job *job, size_t tasks) {
    if (run->parallel && run->parallel->workers <= WORKERS && tasks > 1) {
        run->parallel->run(run->parallel->user, tasks, each_chunk, job);
        return;
    }
    for (size_t i = 0; i < tasks; i++)
        each_chunk(job, i, 0);
}

author_result silmap_each(author_run *run, const char *stage, const size_t *list, size_t count, silmap_visit visit,
                          void *context) {
    each_job job = {.list = list, .count = count, .visit = visit, .context = context};
    for (; job.first < count; job.first += SLICE) {
        size_t n = count - job.first < SLICE ? count - job.first : SLICE;
        each_slice(run, &job, (n + CHUNK - 1) / CHUNK);
        for (unsigned w = 0; w < WORKERS; w++)
            if (job.results[w] != AUTHOR_OK)
                return author_fail(run, (author_result)job.results[w], "no memory for %s", stage);
        if (run->progress && run->progress(run->user, stage, (double)(job.first + n) / (double)count) != 0)
            return author_fail(run, AUTHOR_CANCELLED, "cancelled");
    }
    return AUTHOR_OK;
}

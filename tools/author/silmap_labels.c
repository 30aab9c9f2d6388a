/* SPDX-License-Identifier: Apache-2.0 */
/* The regions of the original, cell by cell, and how much of their area a silmap shows wrongly. */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FINEST 64 /* squares along a cell, of paths, */
#define FINE 32   /* and where the original gives as many */
#define COARSE 16
#define MANY_CELLS 20000
#define JUDGE 37 /* places along a cell; prime, so that they fall between the squares */

/* Squares along a cell. Labels of texels are held exactly if the cells are whole texels. */
static uint32_t choose_edge(const silmap_truth *truth, const silmap_grid *grid) {
    uint32_t most = (size_t)grid->w * grid->h > MANY_CELLS ? COARSE : truth->edges ? FINEST : FINE;
    uint32_t w = truth->picture->width, h = truth->picture->height;
    if (truth->edges)
        return most;
    uint32_t texels = w / grid->w;
    int whole = w % grid->w == 0 && h % grid->h == 0 && h / grid->h == texels;
    if (whole && !truth->resolve && texels >= 8 && texels <= 64)
        return texels;
    if (whole && !truth->resolve && texels < 8)
        return texels * ((7 + texels) / texels);
    return most;
}

typedef struct block_job {
    silmap_labels *labels;
    uint32_t **rows; /* of each worker */
    uint8_t *active;
} block_job;

/* The squares of a cell out of a strip of edge rows; NULL with *uniform set if they are of one region. */
static author_result make_block(silmap_labels *labels, const uint32_t *strip, size_t x, size_t c) {
    uint32_t edge = labels->edge;
    size_t pitch = (size_t)edge * labels->grid->w;
    const uint32_t *at = strip + x * edge;
    labels->uniform[c] = at[0];
    int one = 1;
    for (uint32_t y = 0; y < edge && one; y++)
        for (uint32_t i = 0; i < edge && one; i++)
            one = at[y * pitch + i] == at[0];
    if (one)
        return AUTHOR_OK;
    silmap_block *block = calloc(1, sizeof *block + (size_t)edge * edge);
    if (!block)
        return AUTHOR_NO_MEMORY;
    labels->blocks[c] = block;
    for (uint32_t i = 0; i < edge * edge; i++) {
        uint32_t region = at[(i % edge) * pitch + i / edge], r = 0;
        while (r < block->count && block->regions[r] != region)
            r++;
        if (r == block->count && r < SILMAP_LOCAL)
            block->regions[block->count++] = region;
        block->squares[i] = (uint8_t)(r < SILMAP_LOCAL ? r : SILMAP_LOCAL - 1);
    }
    return AUTHOR_OK;
}

static author_result block_row(void *context, size_t j, unsigned worker, char *error) {
    (void)error;
    block_job *job = context;
    silmap_labels *labels = job->labels;
    const silmap_grid *grid = labels->grid;
    uint32_t edge = labels->edge;
    size_t across = (size_t)edge * grid->w;
    uint32_t *strip = job->rows[worker];
    double dx = 1.0 / (double)across, dy = 1.0 / ((double)edge * grid->h);
    double top = (double)j / grid->h, bottom = (double)(j + 1) / grid->h;
    for (uint32_t y = 0; labels->truth->edges && y < edge; y++)
        silmap_truth_row(labels->truth, ((double)j * edge + y + 0.5) * dy, dx / 2, dx, across, strip + y * across);
    author_result result = AUTHOR_OK;
    for (size_t x = 0; x < grid->w && result == AUTHOR_OK; x++) {
        size_t c = j * grid->w + x, first = x * edge;
        if (silmap_truth_plain(labels->truth, (double)x / grid->w, top, (double)(x + 1) / grid->w, bottom,
                               &labels->uniform[c]))
            continue;
        for (uint32_t y = 0; !labels->truth->edges && y < edge; y++)
            silmap_truth_row(labels->truth, ((double)j * edge + y + 0.5) * dy, ((double)first + 0.5) * dx, dx, edge,
                             strip + y * across + first);
        result = make_block(labels, strip, x, c);
    }
    return result;
}

static author_result make_blocks(author_run *run, silmap_labels *labels) {
    unsigned workers = author_workers(run);
    block_job job = {.labels = labels};
    job.rows = author_alloc(run, workers, sizeof *job.rows);
    author_result result = job.rows ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (unsigned i = 0; i < workers && result == AUTHOR_OK; i++) {
        job.rows[i] = author_alloc(run, (size_t)labels->edge * labels->edge * labels->grid->w, sizeof **job.rows);
        result = job.rows[i] ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    }
    if (result == AUTHOR_OK)
        result = author_for(run, "regions", labels->grid->h, block_row, &job);
    for (unsigned i = 0; job.rows && i < workers; i++)
        free(job.rows[i]);
    free(job.rows);
    return result;
}

/* Samples take the region that they stand in. */
static void label_samples(silmap_labels *labels) {
    const silmap_grid *grid = labels->grid;
    double dx = 1.0 / grid->w, dy = 1.0 / grid->h;
    for (uint32_t j = 0; j < grid->sh; j++) {
        double y = j * dy < 1 ? j * dy + dy / 1024 : 1 - dy / 1024;
        silmap_truth_row(labels->truth, y, dx / 1024, dx, grid->sw, labels->sample + (size_t)j * grid->sw);
        if (!grid->repeat_x)
            silmap_truth_row(labels->truth, y, 1 - dx / 1024, dx, 1, labels->sample + (size_t)(j + 1) * grid->sw - 1);
    }
}

/* Cells that have several regions, and those around them, whose points and corners may move too. */
static author_result list_active(author_run *run, silmap_labels *labels) {
    const silmap_grid *grid = labels->grid;
    size_t cells = (size_t)grid->w * grid->h;
    labels->active = author_alloc(run, cells, sizeof *labels->active);
    if (!labels->active)
        return AUTHOR_NO_MEMORY;
    for (size_t c = 0; c < cells; c++) {
        int near = 0;
        for (int k = 0; k < 4; k++) {
            uint32_t sample = labels->sample[silmap_corner(grid, c, k)];
            near = near || sample != labels->uniform[c];
            for (int m = 0; m < 4; m++) {
                size_t beside = silmap_cell_of(grid, silmap_corner(grid, c, k), m);
                near = near || (beside != SIZE_MAX && labels->blocks[beside]);
            }
        }
        if (near)
            labels->active[labels->active_count++] = c;
    }
    return AUTHOR_OK;
}

author_result silmap_labels_create(author_run *run, const silmap_truth *truth, silmap_grid *grid, silmap_labels *out) {
    size_t cells = (size_t)grid->w * grid->h;
    *out = (silmap_labels){.truth = truth, .grid = grid, .edge = choose_edge(truth, grid)};
    out->sample = author_alloc(run, (size_t)grid->sw * grid->sh, sizeof *out->sample);
    out->uniform = author_alloc(run, cells, sizeof *out->uniform);
    out->blocks = author_alloc(run, cells, sizeof *out->blocks);
    author_result result = out->sample && out->uniform && out->blocks ? make_blocks(run, out) : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK) {
        label_samples(out);
        result = list_active(run, out);
    }
    if (result == AUTHOR_NO_MEMORY)
        author_fail(run, result, "no memory for the regions of %zu cells", cells);
    if (result != AUTHOR_OK)
        silmap_labels_release(out);
    return result;
}

void silmap_labels_release(silmap_labels *labels) {
    size_t cells = labels->grid ? (size_t)labels->grid->w * labels->grid->h : 0;
    for (size_t c = 0; labels->blocks && c < cells; c++)
        free(labels->blocks[c]);
    free(labels->blocks);
    free(labels->sample);
    free(labels->uniform);
    free(labels->active);
    *labels = (silmap_labels){0};
}

/* ---- judging -------------------------------------------------------------------------------------------- */

typedef struct judge_job {
    const silmap_labels *labels;
    zt_silmap_filter filter;
    uint32_t *rows; /* JUDGE rows of each worker */
    double *wrong;  /* of each row of cells */
    uint8_t *defects;
} judge_job;

/* The region that is shown: that of the corners with the most weight. */
static uint32_t shown_region(const judge_job *job, size_t c, const zt_silmap_shape *shape, double x, double y) {
    double weights[4];
    uint32_t regions[4], best = 0;
    zt_silmap_shape_weights(job->filter, shape, zt_silmap_shape_quadrant(shape, x, y), x, y, weights);
    for (int k = 0; k < 4; k++)
        regions[k] = job->labels->sample[silmap_corner(job->labels->grid, c, k)];
    double most = -1;
    for (int k = 0; k < 4; k++) {
        double sum = 0;
        for (int m = 0; m < 4; m++)
            sum += regions[m] == regions[k] ? weights[m] : 0;
        if (sum > most) {
            most = sum;
            best = regions[k];
        }
    }
    return best;
}

static size_t wrong_places(const judge_job *job, size_t c, const uint32_t *strip) {
    const silmap_grid *grid = job->labels->grid;
    size_t pitch = (size_t)JUDGE * grid->w, wrong = 0;
    const uint32_t *at = strip + c % grid->w * JUDGE;
    zt_silmap_cell look = silmap_look(grid, c);
    zt_silmap_shape shape;
    zt_silmap_shape_of(&look, &shape);
    for (int i = 0; i < JUDGE * JUDGE; i++) {
        int x = i % JUDGE, y = i / JUDGE;
        wrong += at[(size_t)y * pitch + (size_t)x] !=
                 shown_region(job, c, &shape, (x + 0.5) / JUDGE, (y + 0.5) / JUDGE);
    }
    return wrong;
}

/* How often the region changes from one side of the block to the other along its border. */
static int changes(const silmap_block *block, uint32_t edge, uint32_t first, uint32_t step) {
    int count = 0;
    for (uint32_t i = 1; i < edge; i++)
        count += block->squares[first + i * step] != block->squares[first + (i - 1) * step];
    return count;
}

static uint8_t defects_of(const silmap_labels *labels, size_t c) {
    const silmap_block *block = labels->blocks[c];
    uint32_t edge = labels->edge, told = 0;
    if (!block)
        return 0;
    uint32_t last = edge * (edge - 1);
    int thin = changes(block, edge, 0, 1) > 1 || changes(block, edge, last, 1) > 1 ||
               changes(block, edge, 0, edge) > 1 || changes(block, edge, edge - 1, edge) > 1;
    int sides = changes(block, edge, 0, 1) + changes(block, edge, last, 1) + changes(block, edge, 0, edge) +
                changes(block, edge, edge - 1, edge);
    for (uint32_t r = 0; r < block->count; r++) {
        int corner = 0;
        for (int k = 0; k < 4; k++)
            corner = corner || labels->sample[silmap_corner(labels->grid, c, k)] == block->regions[r];
        told += (uint32_t)corner;
    }
    /* A region that is in the cell and crosses none of its sides is smaller than the cell. */
    thin = thin || (sides == 0 && block->count > 1);
    return (uint8_t)((thin ? AUTHOR_SILMAP_THIN : 0) |
                     (block->count > 2 && told < block->count ? AUTHOR_SILMAP_JUNCTION : 0));
}

static author_result judge_row(void *context, size_t j, unsigned worker, char *error) {
    (void)error;
    judge_job *job = context;
    const silmap_labels *labels = job->labels;
    const silmap_grid *grid = labels->grid;
    size_t across = (size_t)JUDGE * grid->w;
    uint32_t *rows = job->rows + worker * across * JUDGE;
    double dx = 1.0 / (double)across, dy = 1.0 / ((double)JUDGE * grid->h);
    int paths = labels->truth->edges != NULL;
    for (uint32_t y = 0; paths && y < JUDGE; y++)
        silmap_truth_row(labels->truth, ((double)j * JUDGE + y + 0.5) * dy, dx / 2, dx, across, rows + y * across);
    size_t wrong = 0;
    for (size_t x = 0; x < grid->w; x++) {
        size_t c = j * grid->w + x;
        job->defects[c] |= defects_of(labels, c);
        if (!labels->blocks[c] && !silmap_cuts(grid, c))
            continue;
        for (uint32_t y = 0; !paths && y < JUDGE; y++)
            silmap_truth_row(labels->truth, ((double)j * JUDGE + y + 0.5) * dy, ((double)(x * JUDGE) + 0.5) * dx, dx,
                             JUDGE, rows + y * across + x * JUDGE);
        wrong += wrong_places(job, c, rows);
    }
    job->wrong[j] = (double)wrong;
    return AUTHOR_OK;
}

author_result silmap_labels_judge(author_run *run, const silmap_labels *labels, zt_silmap_filter filter,
                                  double *disagreement, uint8_t *defects) {
    const silmap_grid *grid = labels->grid;
    size_t across = (size_t)JUDGE * grid->w;
    judge_job job = {.labels = labels, .filter = filter, .defects = defects};
    job.rows = author_alloc(run, across * JUDGE, sizeof *job.rows * author_workers(run));
    job.wrong = author_alloc(run, grid->h, sizeof *job.wrong);
    author_result result = job.rows && job.wrong ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK)
        result = author_for(run, "judging", grid->h, judge_row, &job);
    double sum = 0;
    for (uint32_t j = 0; result == AUTHOR_OK && j < grid->h; j++)
        sum += job.wrong[j];
    *disagreement = sum / ((double)across * JUDGE * grid->h);
    free(job.rows);
    free(job.wrong);
    return result;
}

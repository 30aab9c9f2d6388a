/* SPDX-License-Identifier: Apache-2.0 */
/* The regions of the original, cell by cell, and how much of their area a silmap shows wrongly. */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FINE 32 /* squares along a cell */
#define COARSE 16
#define FINER 4 /* places along a square, of paths */
#define MANY_CELLS 20000
#define GAP 8    /* cells that are looked up too, as each row of places has to begin anew */
#define JUDGE 37 /* places along a cell; prime, so that they fall between the squares */

/* Squares along a cell. Labels of texels are held exactly if the cells are whole texels. */
static uint32_t choose_edge(const silmap_truth *truth, const silmap_grid *grid, int hasty) {
    uint32_t most = hasty || (size_t)grid->w * grid->h > MANY_CELLS ? COARSE : FINE;
    uint32_t w = truth->picture->width, h = truth->picture->height, texels = w / grid->w;
    int whole = w % grid->w == 0 && h % grid->h == 0 && h / grid->h == texels;
    if (truth->edges || !whole || truth->resolve || texels > 64)
        return most;
    return texels >= 8 ? texels : texels * ((7 + texels) / texels);
}

/* ---- looking up ----------------------------------------------------------------------------------------- */

/* Regions at places of the texture. */
static void look_up(const silmap_labels *labels, double y, double x0, double dx, size_t count, uint32_t *out) {
    const author_silmap_place *p = &labels->place;
    silmap_truth_row(labels->truth, (y - p->y) / p->height, (x0 - p->x) / p->width, dx / p->width, count, out);
}

/* Regions at pitch x pitch places of each wanted cell of row j. strip: pitch rows of all its cells. */
static void look_up_cells(const silmap_labels *labels, size_t j, uint32_t pitch, const uint8_t *wanted,
                          uint32_t *strip) {
    size_t w = labels->grid->w, across = pitch * w, gap = labels->truth->edges ? GAP : 0;
    double dx = 1.0 / (double)across, dy = 1.0 / ((double)pitch * labels->grid->h);
    for (size_t x = 0, end; x < w; x = end + 1) {
        end = x;
        for (size_t i = x; wanted[x] && i < w && i <= end + gap; i++)
            end = wanted[i] ? i + 1 : end;
        for (uint32_t y = 0; y < pitch && end > x; y++)
            look_up(labels, ((double)(j * pitch + y) + 0.5) * dy, ((double)(x * pitch) + 0.5) * dx, dx,
                    (end - x) * pitch, strip + y * across + x * pitch);
    }
}

/* ---- blocks --------------------------------------------------------------------------------------------- */

typedef struct block_job {
    silmap_labels *labels;
    uint8_t *crossed; /* of each cell: it may have several regions */
    uint32_t *strips; /* of each worker */
    size_t strip;
    uint8_t *places;
} block_job;

static uint32_t cell_at(double at, uint32_t n) {
    return at <= 0 ? 0 : at >= n ? n - 1 : (uint32_t)at;
}

/* Marks the cells that an edge passes. */
static void mark_edge(const silmap_labels *labels, const silmap_edge *edge, uint8_t *crossed) {
    const silmap_grid *grid = labels->grid;
    const author_silmap_place *p = &labels->place;
    double x0 = (p->x + edge->x0 * p->width) * grid->w, x1 = (p->x + edge->x1 * p->width) * grid->w;
    double y0 = (p->y + edge->y0 * p->height) * grid->h, y1 = (p->y + edge->y1 * p->height) * grid->h;
    uint32_t last = cell_at(y1 + 1e-6, grid->h);
    for (uint32_t j = cell_at(y0 - 1e-6, grid->h); j <= last; j++) {
        double s = (j - y0) / (y1 - y0), t = (j + 1 - y0) / (y1 - y0);
        double from = x0 + fmin(fmax(s, 0), 1) * (x1 - x0), to = x0 + fmin(fmax(t, 0), 1) * (x1 - x0);
        uint32_t end = cell_at(fmax(from, to) + 1e-6, grid->w);
        for (uint32_t i = cell_at(fmin(from, to) - 1e-6, grid->w); i <= end; i++)
            crossed[(size_t)j * grid->w + i] = 1;
    }
}

/* Edges along x are in no list: they cross the line down the middle of a cell. The region of cells that nothing crosses
 * is that of this line. */
static void mark_along(const silmap_labels *labels, size_t j, uint32_t *row, uint8_t *crossed) {
    uint32_t w = labels->grid->w, pitch = labels->edge * labels->finer, *first = labels->uniform + j * w;
    for (uint32_t i = 0; i < pitch; i++) {
        double y = ((double)(j * pitch + i) + 0.5) / ((double)pitch * labels->grid->h);
        look_up(labels, y, 0.5 / w, 1.0 / w, w, i ? row : first);
        for (uint32_t x = 0; i && x < w; x++)
            crossed[x] |= row[x] != first[x];
    }
}

static void mark_texels(const silmap_labels *labels, size_t j, uint8_t *crossed) {
    const author_silmap_place *p = &labels->place;
    double w = labels->grid->w, h = labels->grid->h;
    double top = ((double)j / h - p->y) / p->height, bottom = ((double)(j + 1) / h - p->y) / p->height;
    for (uint32_t x = 0; x < labels->grid->w; x++)
        crossed[x] = !silmap_truth_plain(labels->truth, (x / w - p->x) / p->width, top, ((x + 1) / w - p->x) / p->width,
                                         bottom, &labels->uniform[j * labels->grid->w + x]);
}

/* The block of a cell out of its places in a strip; none if they are of one region. */
static author_result make_block(silmap_labels *labels, const uint32_t *at, size_t across, uint8_t *places, size_t c) {
    uint32_t pitch = labels->edge * labels->finer, regions[SILMAP_LOCAL], count = 0;
    for (uint32_t i = 0; i < pitch * pitch; i++) {
        uint32_t region = at[i % pitch * across + i / pitch], r = 0;
        while (r < count && regions[r] != region)
            r++;
        if (r == count && r < SILMAP_LOCAL)
            regions[count++] = region;
        places[i] = (uint8_t)(r < SILMAP_LOCAL ? r : SILMAP_LOCAL - 1);
    }
    labels->uniform[c] = at[0];
    if (count == 1)
        return AUTHOR_OK;
    labels->blocks[c] = silmap_block_create(regions, count, places, labels->edge, labels->finer);
    return labels->blocks[c] ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static author_result block_row(void *context, size_t j, unsigned worker, char *error) {
    (void)error;
    block_job *job = context;
    silmap_labels *labels = job->labels;
    size_t w = labels->grid->w, pitch = (size_t)labels->edge * labels->finer;
    uint32_t *strip = job->strips + worker * job->strip;
    uint8_t *crossed = job->crossed + j * w;
    if (labels->truth->edges)
        mark_along(labels, j, strip, crossed);
    else
        mark_texels(labels, j, crossed);
    look_up_cells(labels, j, (uint32_t)pitch, crossed, strip);
    author_result result = AUTHOR_OK;
    for (size_t x = 0; x < w && result == AUTHOR_OK; x++)
        if (crossed[x])
            result = make_block(labels, strip + x * pitch, pitch * w, job->places + worker * pitch * pitch, j * w + x);
    return result;
}

static author_result make_blocks(author_run *run, silmap_labels *labels) {
    const silmap_truth *truth = labels->truth;
    size_t cells = (size_t)labels->grid->w * labels->grid->h, pitch = (size_t)labels->edge * labels->finer;
    block_job job = {.labels = labels, .strip = pitch * pitch * labels->grid->w};
    job.strips = author_alloc(run, job.strip * author_workers(run), sizeof *job.strips);
    job.places = author_alloc(run, pitch * pitch, author_workers(run));
    job.crossed = author_alloc(run, cells, 1);
    author_result result = job.strips && job.places && job.crossed ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (size_t e = 0; result == AUTHOR_OK && e < truth->edge_count; e++)
        mark_edge(labels, &truth->edges[e], job.crossed);
    if (result == AUTHOR_OK)
        result = author_for(run, "regions", labels->grid->h, block_row, &job);
    free(job.strips);
    free(job.places);
    free(job.crossed);
    return result;
}

/* Samples take the region that they stand in. */
static void label_samples(silmap_labels *labels) {
    const silmap_grid *grid = labels->grid;
    double dx = 1.0 / grid->w, dy = 1.0 / grid->h;
    for (uint32_t j = 0; j < grid->sh; j++) {
        double y = j * dy < 1 ? j * dy + dy / 1024 : 1 - dy / 1024;
        look_up(labels, y, dx / 1024, dx, grid->sw, labels->sample + (size_t)j * grid->sw);
        if (!grid->repeat_x)
            look_up(labels, y, 1 - dx / 1024, dx, 1, labels->sample + (size_t)(j + 1) * grid->sw - 1);
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

author_result silmap_labels_create(author_run *run, const silmap_truth *truth, const author_silmap_place *place,
                                   int hasty, silmap_grid *grid, silmap_labels *out) {
    size_t cells = (size_t)grid->w * grid->h;
    *out = (silmap_labels){.truth = truth, .place = *place, .grid = grid, .finer = truth->edges ? FINER : 1};
    out->edge = choose_edge(truth, grid, hasty);
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
    int weighted;
    uint32_t *strips; /* of each worker: JUDGE rows */
    uint8_t *wanted;  /* of each cell */
    double *wrong;    /* of each row of cells */
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

static double wrong_places(const judge_job *job, size_t c, const uint32_t *strip) {
    const silmap_grid *grid = job->labels->grid;
    size_t pitch = (size_t)JUDGE * grid->w;
    const uint32_t *at = strip + c % grid->w * JUDGE;
    zt_silmap_cell look = silmap_look(grid, c);
    zt_silmap_shape shape;
    double wrong = 0;
    zt_silmap_shape_of(&look, &shape);
    for (int i = 0; i < JUDGE * JUDGE; i++) {
        int x = i % JUDGE, y = i / JUDGE;
        uint32_t is = at[(size_t)y * pitch + (size_t)x];
        uint32_t shown = shown_region(job, c, &shape, (x + 0.5) / JUDGE, (y + 0.5) / JUDGE);
        wrong += is == shown ? 0 : job->weighted ? silmap_weight(job->labels, shown, is) : 1;
    }
    return wrong;
}

static uint8_t defects_of(const silmap_labels *labels, size_t c) {
    const silmap_block *block = labels->blocks[c];
    uint32_t told = 0;
    if (!block)
        return 0;
    for (uint32_t r = 0; r < block->count; r++) {
        int corner = 0;
        for (int k = 0; k < 4; k++)
            corner = corner || labels->sample[silmap_corner(labels->grid, c, k)] == block->regions[r];
        told += (uint32_t)corner;
    }
    return (uint8_t)((block->thin ? AUTHOR_SILMAP_THIN : 0) |
                     (block->count > 2 && told < block->count ? AUTHOR_SILMAP_JUNCTION : 0));
}

static author_result judge_row(void *context, size_t j, unsigned worker, char *error) {
    (void)error;
    judge_job *job = context;
    const silmap_labels *labels = job->labels;
    size_t w = labels->grid->w;
    uint32_t *strip = job->strips + worker * w * JUDGE * JUDGE;
    uint8_t *wanted = job->wanted + j * w;
    for (size_t c = j * w; c < (j + 1) * w; c++)
        wanted[c - j * w] = labels->blocks[c] || silmap_cuts(labels->grid, c);
    look_up_cells(labels, j, JUDGE, wanted, strip);
    for (size_t c = j * w; c < (j + 1) * w; c++) {
        if (job->defects)
            job->defects[c] |= defects_of(labels, c);
        if (wanted[c - j * w])
            job->wrong[j] += wrong_places(job, c, strip);
    }
    return AUTHOR_OK;
}

author_result silmap_labels_judge(author_run *run, const silmap_labels *labels, zt_silmap_filter filter, int weighted,
                                  double *disagreement, uint8_t *defects) {
    const silmap_grid *grid = labels->grid;
    size_t cells = (size_t)grid->w * grid->h, strip = (size_t)JUDGE * JUDGE * grid->w;
    judge_job job = {.labels = labels, .filter = filter, .weighted = weighted, .defects = defects};
    job.strips = author_alloc(run, strip * author_workers(run), sizeof *job.strips);
    job.wanted = author_alloc(run, cells, 1);
    job.wrong = author_alloc(run, grid->h, sizeof *job.wrong);
    author_result result = job.strips && job.wanted && job.wrong ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK)
        result = author_for(run, "judging", grid->h, judge_row, &job);
    double sum = 0;
    for (uint32_t j = 0; result == AUTHOR_OK && j < grid->h; j++)
        sum += job.wrong[j];
    *disagreement = sum / ((double)cells * JUDGE * JUDGE);
    free(job.strips);
    free(job.wanted);
    free(job.wrong);
    return result;
}

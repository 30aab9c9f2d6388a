/* SPDX-License-Identifier: Apache-2.0 */
/* Points of photographs, moved where that lowers the error of the picture. */
#include "silmap_fit.h"

#include <stdlib.h>

typedef struct polish_job {
    const silmap_model *model;
    silmap_grid *grid;
    uint32_t *moved;
    uint32_t now;
    silmap_pattern pattern;
} polish_job;

/* The mean weights of the corners over a texel. */
static void mean_weights(const polish_job *job, const silmap_view *view, uint32_t x, uint32_t y, float mean[4]) {
    silmap_parts parts;
    double sum[4] = {0};
    silmap_split(view, x, y, job->pattern, &parts);
    for (int i = 0; i < parts.count; i++)
        for (int k = 0; k < 4; k++)
            sum[k] += parts.weights[i][k];
    for (int k = 0; k < 4; k++)
        mean[k] = (float)(sum[k] / parts.count);
}

/* The error of some texels of a cell, nearly: corners are mixed as they are displayed, which spares the curve at every
 * place. It serves to compare points. */
static double quick_error(const polish_job *job, const silmap_view *view, const silmap_span *span) {
    const silmap_model *model = job->model;
    uint32_t channels = model->picture->channels;
    float corners[4][SILMAP_CHANNELS];
    for (int k = 0; k < 4; k++)
        for (uint32_t ch = 0; ch < channels; ch++)
            corners[k][ch] = silmap_code(model->curve, ch, view->corners[k][ch]);
    double sum = 0;
    for (uint32_t y = span->y0; y < span->y1; y++) {
        const float *wanted = model->target + ((size_t)y * model->width + span->x0) * channels;
        for (uint32_t x = span->x0; x < span->x1; x++, wanted += channels) {
            float w[4];
            mean_weights(job, view, x, y, w);
            for (uint32_t ch = 0; ch < channels; ch++) {
                float shown = w[0] * corners[0][ch] + w[1] * corners[1][ch] + w[2] * corners[2][ch] +
                              w[3] * corners[3][ch];
                sum += (double)((shown - wanted[ch]) * (shown - wanted[ch]));
            }
        }
    }
    return sum;
}

/* The error of the part of a cell in which its arm to a neighbour runs: no other depends on the neighbour's point. */
static double arm_error(const polish_job *job, size_t c, int arm) {
    silmap_view view = silmap_view_of(job->model, c);
    silmap_span span = view.span;
    uint32_t across = (uint32_t)((view.left + view.shape.px) / view.sx),
             down = (uint32_t)((view.top + view.shape.py) / view.sy);
    if (arm == SILMAP_W && across + 1 < span.x1)
        span.x1 = across + 1;
    if (arm == SILMAP_N && down + 1 < span.y1)
        span.y1 = down + 1;
    if (arm == SILMAP_E && across > span.x0)
        span.x0 = across;
    if (arm == SILMAP_S && down > span.y0)
        span.y0 = down;
    return quick_error(job, &view, &span);
}

/* The error of a cell and of those that its cut arms lead to, as far as it depends on the cell's point; as soon as it
 * is above the limit, no more of it. */
static double neighbourhood_error(const polish_job *job, size_t c, unsigned cuts, double limit) {
    static const int8_t opposite[4] = {SILMAP_E, SILMAP_S, SILMAP_W, SILMAP_N};
    silmap_view view = silmap_view_of(job->model, c);
    double sum = quick_error(job, &view, &view.span);
    for (int arm = 0; arm < 4 && sum < limit; arm++) {
        size_t next = silmap_next(job->grid, c, arm);
        if ((cuts >> arm & 1) && next != SIZE_MAX)
            sum += arm_error(job, next, opposite[arm]);
    }
    return sum;
}

static const int8_t steps[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};

static author_result visit_polish(void *context, size_t c, unsigned worker) {
    (void)worker;
    polish_job *job = context;
    int lately = job->moved[c] + 1 >= job->now;
    for (int arm = 0; arm < 4; arm++) {
        size_t next = silmap_next(job->grid, c, arm);
        lately = lately || (next != SIZE_MAX && job->moved[next] + 1 >= job->now);
    }
    unsigned cuts = silmap_cuts(job->grid, c);
    if (!lately || !cuts)
        return AUTHOR_OK;
    uint8_t *cell = &job->grid->cells[c];
    uint8_t old = *cell, best = old;
    int x = old & 7, y = old >> 3 & 7;
    double least = neighbourhood_error(job, c, cuts, INFINITY) - 1e-9;
    for (int i = 0; i < 8; i++) {
        int nx = x + steps[i][0], ny = y + steps[i][1];
        if (nx < 0 || ny < 0 || nx > 7 || ny > 7)
            continue;
        *cell = (uint8_t)((old & ~0x3f) | ny << 3 | nx);
        double error = neighbourhood_error(job, c, cuts, least);
        if (error < least) {
            least = error;
            best = *cell;
        }
    }
    *cell = best;
    if (best != old)
        job->moved[c] = job->now;
    return AUTHOR_OK;
}

author_result silmap_points_polish(author_run *run, const silmap_model *model, silmap_grid *grid, int sweeps) {
    size_t cells = (size_t)grid->w * grid->h, count = 0;
    polish_job job = {.model = model, .grid = grid};
    /* About as many places in a cell whatever the texels in it are. */
    uint32_t texels = model->width / grid->w;
    job.pattern = (silmap_pattern){texels >= 6 ? 1 : texels >= 3 ? 2 : 4, 1};
    job.moved = author_alloc(run, cells, sizeof *job.moved);
    size_t *cut = author_alloc(run, cells, sizeof *cut), *list = author_alloc(run, cells, sizeof *list);
    author_result result = job.moved && cut && list ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (size_t c = 0; result == AUTHOR_OK && c < cells; c++)
        if (silmap_cuts(grid, c))
            cut[count++] = c;
    /* A cell's error depends on its neighbours' points, so that those that move at the same time are two cells away. */
    uint32_t classes = SILMAP_CLASSES(3) * SILMAP_CLASSES(3);
    for (uint32_t i = 0; i < classes * (uint32_t)sweeps && result == AUTHOR_OK; i++) {
        if (i % classes == 0)
            job.now++;
        size_t n = silmap_select(cut, count, grid->w, grid->h, 3, i % classes, list);
        result = n ? silmap_each(run, "points", list, n, visit_polish, &job) : AUTHOR_OK;
    }
    free(job.moved);
    free(cut);
    free(list);
    return result;
}

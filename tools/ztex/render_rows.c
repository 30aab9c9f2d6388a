/* SPDX-License-Identifier: Apache-2.0 */
/* Lookups, one or a grid of them for each pixel, in parallel over rows; then what makes a picture of them. */
#include "render.h"

#include <math.h>
#include <string.h>

#define ROWS_AT_ONCE 64 /* each keeps a diagnosis, so that the first row's error is reported whatever thread ran it */
#define CHECKER_EDGE 8  /* pixels */
#define CHECKER_DARK 0.3185468f /* linear values of the sRGB greys 0.6 and 0.8 */
#define CHECKER_LIGHT 0.6038274f

typedef struct row_job {
    const zt_sampler *sampler;
    const render_style *style;
    const render_view *view;
    render_scene scene; /* with style->space */
    uint32_t y;         /* of row 0 of the job */
    float *rgba;
    size_t pitch;
    zt_result results[ROWS_AT_ONCE];
    zt_diag diags[ROWS_AT_ONCE];
} row_job;

/* Lookup number s of a row of sub-pixels: they come pixel by pixel, in a pixel row by row. In pixels. */
static void place_of(const row_job *job, uint32_t y, uint64_t s, double place[2]) {
    uint32_t n = job->style->supersample;
    uint64_t x = s / ((uint64_t)n * n), sub = s % ((uint64_t)n * n);
    place[0] = (double)x + ((double)(sub % n) + 0.5) / n;
    place[1] = (double)y + ((double)(sub / n) + 0.5) / n;
}

static zt_point point_of(const row_job *job, uint32_t y, uint64_t s) {
    const render_style *style = job->style;
    const render_view *view = job->view;
    uint32_t n = style->supersample;
    double place[2];
    place_of(job, y, s, place);
    double across = place[0] / style->width, down = place[1] / style->height;
    return (zt_point){.u = view->u0 + (view->u1 - view->u0) * across,
                      .v = view->v0 + (view->v1 - view->v0) * down,
                      .w = style->w,
                      .du_dx = (view->u1 - view->u0) / ((double)style->width * n),
                      .dv_dy = (view->v1 - view->v0) / ((double)style->height * n),
                      .array_layer = style->array_layer};
}

static void put_background(const render_style *style, uint32_t x, uint32_t y, float p[4]) {
    float behind = 1.0f - p[3];
    float grey = (x / CHECKER_EDGE + y / CHECKER_EDGE) % 2 ? CHECKER_DARK : CHECKER_LIGHT;
    if (style->background == BACKGROUND_NONE)
        return;
    for (int c = 0; c < 3; c++)
        p[c] += behind * (style->background == BACKGROUND_PLAIN ? style->plain[c] : grey);
    p[3] = 1.0f;
}

/* From premultiplied linear light to what the picture holds. */
static void finish_pixel(const render_style *style, uint32_t x, uint32_t y, float p[4]) {
    for (int c = 0; c < 3; c++)
        p[c] *= style->gain;
    put_background(style, x, y, p);
    if (style->straight)
        for (int c = 0; c < 3; c++)
            p[c] = p[3] > 0.0f ? p[c] / p[3] : 0.0f;
    if (style->transfer != ZT_TRANSFER_LINEAR)
        for (int c = 0; c < 3; c++)
            p[c] = zt_transfer_encode(style->transfer, p[c]);
}

static zt_result look_up(const row_job *job, uint32_t y, uint64_t first, size_t count, float *texels, zt_diag *diag) {
    zt_point points[RENDER_BATCH];
    double places[RENDER_BATCH][2];
    if (job->style->space) {
        for (size_t i = 0; i < count; i++)
            place_of(job, y, first + i, places[i]);
        return render_scene_sample(&job->scene, job->sampler, (const double(*)[2])places, count,
                                   1.0 / job->style->supersample, texels, diag);
    }
    for (size_t i = 0; i < count; i++)
        points[i] = point_of(job, y, first + i);
    return zt_sample(job->sampler, points, count, texels, diag);
}

static void render_row(void *context, size_t index, unsigned worker) {
    row_job *job = context;
    const render_style *style = job->style;
    uint32_t y = job->y + (uint32_t)index;
    uint32_t per_pixel = style->supersample * style->supersample;
    uint64_t total = (uint64_t)style->width * per_pixel;
    float *row = job->rgba + index * job->pitch;
    float texels[4 * RENDER_BATCH];
    (void)worker;
    memset(row, 0, (size_t)style->width * 4 * sizeof *row);
    for (uint64_t done = 0; done < total; done += RENDER_BATCH) {
        size_t count = total - done < RENDER_BATCH ? (size_t)(total - done) : RENDER_BATCH;
        job->results[index] = look_up(job, y, done, count, texels, &job->diags[index]);
        if (job->results[index] != ZT_OK)
            return;
        for (size_t i = 0; i < 4 * count; i++)
            row[4 * ((done + i / 4) / per_pixel) + i % 4] += texels[i] / (float)per_pixel;
    }
    for (uint32_t x = 0; x < style->width; x++)
        finish_pixel(style, x, y, row + 4 * (size_t)x);
}

zt_result render_rows(const zt_sampler *sampler, const render_style *style, const render_view *view, uint32_t y,
                      uint32_t count, float *rgba, size_t pitch, const zt_parallel *parallel, zt_diag *diag) {
    row_job job;
    for (uint32_t done = 0; done < count; done += ROWS_AT_ONCE) {
        size_t rows = count - done < ROWS_AT_ONCE ? count - done : ROWS_AT_ONCE;
        memset(&job, 0, sizeof job);
        job.sampler = sampler;
        job.style = style;
        job.view = view;
        job.y = y + done;
        job.rgba = rgba + done * pitch;
        job.pitch = pitch;
        if (style->space && render_scene_open(style, view, &job.scene))
            return ZT_BAD_ARGUMENT;
        if (parallel)
            parallel->run(parallel->user, rows, render_row, &job);
        for (size_t i = 0; !parallel && i < rows; i++)
            render_row(&job, i, 0);
        for (size_t i = 0; i < rows; i++) {
            if (job.results[i] == ZT_OK)
                continue;
            *diag = job.diags[i];
            return job.results[i];
        }
    }
    return ZT_OK;
}

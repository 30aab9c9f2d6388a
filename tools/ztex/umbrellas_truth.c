/* SPDX-License-Identifier: Apache-2.0 */
/* What a texture shows, averaged over boxes: what coarser levels are fitted to and measured by. */
#include "umbrellas.h"

#include <stdlib.h>
#include <string.h>

#include "make_author.h"

#define CHUNK 256 /* lookups at a time */

typedef struct looking {
    const zt_sampler *sampler;
    author_picture *out;
    const umbrellas_view *view;
} looking;

static zt_point place_of(const umbrellas_view *v, uint32_t x, uint32_t y, uint32_t sample) {
    double n = v->samples, right = (sample % v->samples + 0.5) / n, down = (sample / v->samples + 0.5) / n;
    if (v->phases)
        right = down = y < v->height ? 0 : 0.5;
    zt_point point = {.u = (x + right) / v->width, .v = (y % v->height + down) / v->height};
    if (v->step) {
        point.du_dx = v->step[0];
        point.dv_dy = v->step[1];
    }
    return point;
}

static author_result look_at_row(void *context, size_t index, unsigned worker, char *error) {
    const looking *l = context;
    uint32_t per = l->view->samples * l->view->samples, y = (uint32_t)index;
    size_t total = (size_t)l->out->width * per;
    float *row = l->out->texels + (size_t)y * l->out->width * 4, rgba[CHUNK * 4];
    zt_point points[CHUNK];
    (void)worker;
    memset(row, 0, (size_t)l->out->width * 4 * sizeof *row);
    for (size_t first = 0; first < total; first += CHUNK) {
        size_t count = total - first < CHUNK ? total - first : CHUNK;
        zt_diag diag = {.offset = UINT64_MAX};
        for (size_t i = 0; i < count; i++)
            points[i] = place_of(l->view, (uint32_t)((first + i) / per), y, (uint32_t)((first + i) % per));
        if (zt_sample(l->sampler, points, count, rgba, &diag) != ZT_OK) {
            snprintf(error, AUTHOR_ERROR, "looking up what level 0 shows: %s", diag.text);
            return AUTHOR_INTERNAL;
        }
        for (size_t i = 0; i < 4 * count; i++)
            row[(first + i / 4) / per * 4 + i % 4] += rgba[i] / (float)per;
    }
    return AUTHOR_OK;
}

int umbrellas_look(author_run *run, const zt_file *file, uint32_t texture, const umbrellas_view *view,
                   author_picture *out) {
    looking l = {.out = out, .view = view};
    zt_sampler_options how = {.size = sizeof how, .filter = ZT_FILTER_TRILINEAR};
    zt_diag diag = {.offset = UINT64_MAX};
    zt_sampler *sampler = NULL;
    uint32_t height = view->phases ? 2 * view->height : view->height;
    *out = (author_picture){0};
    zt_result opened = zt_sampler_open(file, texture, &how, &diag, &sampler);
    if (opened != ZT_OK)
        return cmd_fail_result("make umbrellas", opened, &diag);
    l.sampler = sampler;
    author_result result = author_picture_create(run, view->width, height, 4, out);
    if (result == AUTHOR_OK)
        result = author_for(run, "looking", height, look_at_row, &l);
    zt_sampler_close(sampler);
    if (result != AUTHOR_OK)
        author_picture_release(out);
    return make_author_status(result, run);
}

void umbrellas_step(uint32_t grid_x, uint32_t grid_y, uint32_t level, double step[2]) {
    double cells = (double)(UINT32_C(1) << level) / UMBRELLAS_PIXELS;
    step[0] = cells / grid_x;
    step[1] = cells / grid_y;
}

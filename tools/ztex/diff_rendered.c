/* SPDX-License-Identifier: Apache-2.0 */
/* --rendered: both files looked up at the same points, as a renderer sees them, whatever is behind. */
#include "diff.h"

#include <stdlib.h>

typedef struct lookup {
    zt_sampler *samplers[2];
    zt_point *points;
    float *colours[2];
} lookup;

static void lookup_close(lookup *l) {
    for (int i = 0; i < 2; i++) {
        zt_sampler_close(l->samplers[i]);
        free(l->colours[i]);
    }
    free(l->points);
}

static int lookup_open(dif_job *job, uint32_t texture, uint32_t layer, lookup *l) {
    zt_diag diag;
    zt_sampler_options options = {.size = sizeof options, .layer = layer};
    *l = (lookup){0};
    l->points = calloc(job->size, sizeof *l->points);
    for (int i = 0; i < 2; i++) {
        zt_result result = zt_sampler_open(i ? job->b : job->a, texture, &options, &diag, &l->samplers[i]);
        if (result != ZT_OK)
            return cmd_fail_result(job->args->operands[i], result, &diag);
        l->colours[i] = calloc(job->size, 4 * sizeof(float));
        if (!l->colours[i] || !l->points)
            return cmd_fail(CMD_INTERNAL, "out of memory");
    }
    return CMD_OK;
}

static int compare_row(dif_job *job, lookup *l, uint32_t y, dif_error *error) {
    double step = 1.0 / job->size;
    zt_diag diag;
    for (uint32_t x = 0; x < job->size; x++)
        l->points[x] = (zt_point){.u = (x + 0.5) * step, .v = (y + 0.5) * step, .du_dx = step, .dv_dy = step};
    for (int i = 0; i < 2; i++) {
        zt_result result = zt_sample(l->samplers[i], l->points, job->size, l->colours[i], &diag);
        if (result != ZT_OK)
            return cmd_fail_result(job->args->operands[i], result, &diag);
    }
    dif_error_add(error, l->colours[0], l->colours[1], (size_t)job->size * 4);
    return cmd_interrupted() ? cmd_cancelled() : CMD_OK;
}

static int compare_layer(dif_job *job, uint32_t texture, uint32_t layer) {
    lookup l;
    dif_error error = {0};
    char where[64];
    int status = lookup_open(job, texture, layer, &l);
    for (uint32_t y = 0; y < job->size && status == CMD_OK; y++)
        status = compare_row(job, &l, y, &error);
    lookup_close(&l);
    if (status != CMD_OK || error.most <= job->tolerance)
        return status;
    snprintf(where, sizeof where, "texture %u/layer %u", (unsigned)texture, (unsigned)layer);
    dif_report_error(job, "rendered", where, &error);
    return CMD_OK;
}

int dif_rendered(dif_job *job) {
    zt_texture_info a, b;
    zt_file_info info_a, info_b;
    int status = CMD_OK;
    for (uint32_t i = 0; zt_get_texture(job->a, i, &a) == ZT_OK && zt_get_texture(job->b, i, &b) == ZT_OK; i++) {
        for (uint32_t k = 0; k < a.layer_count && k < b.layer_count && status == CMD_OK; k++)
            status = compare_layer(job, i, k);
        char text_a[16], text_b[16], where[32];
        snprintf(text_a, sizeof text_a, "%u", (unsigned)a.layer_count);
        snprintf(text_b, sizeof text_b, "%u", (unsigned)b.layer_count);
        snprintf(where, sizeof where, "textures/%u/layers", (unsigned)i);
        if (status == CMD_OK && a.layer_count != b.layer_count)
            dif_report(job, "rendered", where, text_a, text_b);
    }
    zt_get_file(job->a, &info_a);
    zt_get_file(job->b, &info_b);
    if (status == CMD_OK && info_a.texture_count != info_b.texture_count) {
        char text_a[16], text_b[16];
        snprintf(text_a, sizeof text_a, "%u", (unsigned)info_a.texture_count);
        snprintf(text_b, sizeof text_b, "%u", (unsigned)info_b.texture_count);
        dif_report(job, "rendered", "textures", text_a, text_b);
    }
    return status;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* A picture into linear light, row by row into its small copy. */
#include "load_linear.h"
#include "light_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Where a source pixel's stretch falls in the reduced picture: the first cell, and how much of the pixel lies in each
 * of the cells. A reduced cell is never smaller than a pixel, so there are at most two. */
typedef struct share {
    uint32_t cell;
    float first, second;
} share;

typedef struct linear_job {
    light_rows rows;
    float *line; /* a row in linear light */
    share *across;
    author_picture *out;
} linear_job;

static share share_of(uint32_t position, uint32_t from, uint32_t to) {
    double begin = (double)position * to / from, end = (double)(position + 1) * to / from;
    double cell = floor(begin), next = cell + 1.0;
    share s = {(uint32_t)cell, (float)(end - begin), 0.0f};
    if (end > next && s.cell + 1 < to)
        s = (share){s.cell, (float)(next - begin), (float)(end - next)};
    return s;
}

/* The row, weighted, onto the cells of one row of out. */
static void add_row(const linear_job *job, float weight, float *out) {
    uint32_t n = job->rows.channels;
    for (uint32_t x = 0; x < job->rows.info->width; x++) {
        const float *from = job->line + (size_t)x * n;
        const share *s = &job->across[x];
        float *to = out + (size_t)s->cell * n;
        for (uint32_t c = 0; c < n; c++)
            to[c] += from[c] * (s->first * weight);
        for (uint32_t c = 0; s->second > 0.0f && c < n; c++)
            to[n + c] += from[c] * (s->second * weight);
    }
}

static void reduce_row(void *user, uint32_t y, size_t first) {
    const linear_job *job = user;
    const img_info *info = job->rows.info;
    size_t count = (size_t)info->width * job->rows.channels, stride = (size_t)job->out->width * job->rows.channels;
    share down = share_of(y, info->height, job->out->height);
    for (size_t i = 0; i < count; i++)
        job->line[i] = light_rows_light(&job->rows, first + i);
    add_row(job, down.first, job->out->texels + down.cell * stride);
    if (down.second > 0.0f)
        add_row(job, down.second, job->out->texels + (down.cell + 1) * stride);
}

static void choose_size(const img_info *info, uint64_t max_texels, uint32_t *width, uint32_t *height) {
    double texels = (double)info->width * info->height;
    double scale = texels > (double)max_texels ? sqrt((double)max_texels / texels) : 1.0;
    *width = (uint32_t)fmax(1.0, floor(info->width * scale));
    *height = (uint32_t)fmax(1.0, floor(info->height * scale));
}

static author_result load(linear_job *job, img_reader *reader, uint64_t max_texels, char *error) {
    const img_info *info = img_get_info(reader);
    author_run run = {0};
    uint32_t width, height, channels = info->channels < 3 ? 1 : 3, transfer = info->transfer;
    choose_size(info, max_texels, &width, &height);
    if (!zt_transfer_known(transfer))
        transfer = info->type == IMG_U8 || info->type == IMG_U16 ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR;
    int failed = light_rows_open(&job->rows, reader, channels, transfer, info->type == IMG_U8 ? IMG_U8 : IMG_FLOAT);
    job->line = malloc((size_t)info->width * channels * sizeof *job->line);
    job->across = malloc((size_t)info->width * sizeof *job->across);
    author_result result = author_picture_create(&run, width, height, channels, job->out);
    if (result != AUTHOR_OK || failed || !job->line || !job->across) {
        snprintf(error, IMG_ERROR, "out of memory");
        return AUTHOR_NO_MEMORY;
    }
    for (uint32_t x = 0; x < info->width; x++)
        job->across[x] = share_of(x, info->width, width);
    return light_rows_each(&job->rows, reduce_row, job, error) ? AUTHOR_BAD_INPUT : AUTHOR_OK;
}

author_result load_linear(const char *path, uint64_t max_texels, author_picture *out, char *error) {
    linear_job job = {.out = out};
    *out = (author_picture){0};
    img_reader *reader = img_open(path, NULL, error);
    if (!reader)
        return AUTHOR_BAD_INPUT;
    author_result result = load(&job, reader, max_texels, error);
    if (result != AUTHOR_OK)
        author_picture_release(out);
    light_rows_close(&job.rows);
    free(job.line);
    free(job.across);
    img_close(reader);
    return result;
}

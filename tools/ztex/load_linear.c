/* SPDX-License-Identifier: Apache-2.0 */
/* A picture into linear light, band by band, so that a small copy of a large picture needs little memory. */
#include "load_linear.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BAND = 32, SRGB = 13 };

/* Where a source pixel's stretch falls in the reduced picture: the first cell, and how much of the pixel lies in each of the cells. A
 * reduced cell is never smaller than a pixel, so there are at most two. */
typedef struct share {
    uint32_t cell;
    float first, second;
} share;

typedef struct linear_job {
    img_reader *reader;
    const img_info *info;
    uint32_t channels, transfer;
    float table[256]; /* of 8-bit values */
    unsigned char *rows;
    float *line; /* a row in linear light */
    share *across;
} linear_job;

static share share_of(uint32_t position, uint32_t from, uint32_t to) {
    double begin = (double)position * to / from, end = (double)(position + 1) * to / from;
    double cell = floor(begin), next = cell + 1.0;
    share s = {(uint32_t)cell, (float)(end - begin), 0.0f};
    if (end > next && s.cell + 1 < to)
        s = (share){s.cell, (float)(next - begin), (float)(end - next)};
    return s;
}

static void decode_row(const linear_job *job, const unsigned char *row) {
    size_t count = (size_t)job->info->width * job->channels;
    if (job->info->type == IMG_U8) {
        for (size_t i = 0; i < count; i++)
            job->line[i] = job->table[row[i]];
        return;
    }
    const float *values = (const float *)(const void *)row;
    for (size_t i = 0; i < count; i++)
        job->line[i] = zt_transfer_decode(job->transfer, values[i]);
}

/* The row, weighted, onto the cells of one row of out. */
static void add_row(const linear_job *job, float weight, float *out) {
    uint32_t n = job->channels;
    for (uint32_t x = 0; x < job->info->width; x++) {
        const float *from = job->line + (size_t)x * n;
        const share *s = &job->across[x];
        float *to = out + (size_t)s->cell * n;
        for (uint32_t c = 0; c < n; c++)
            to[c] += from[c] * (s->first * weight);
        for (uint32_t c = 0; s->second > 0.0f && c < n; c++)
            to[n + c] += from[c] * (s->second * weight);
    }
}

static int reduce(const linear_job *job, author_picture *out, char *error) {
    const img_info *info = job->info;
    img_type type = info->type == IMG_U8 ? IMG_U8 : IMG_FLOAT;
    size_t pitch = (size_t)info->width * job->channels * img_type_size(type);
    size_t stride = (size_t)out->width * job->channels;
    for (uint32_t y = 0; y < info->height; y += BAND) {
        uint32_t count = info->height - y < BAND ? info->height - y : BAND;
        if (img_read_rows(job->reader, 0, y, count, job->channels, type, job->rows, pitch, error))
            return -1;
        for (uint32_t i = 0; i < count; i++) {
            share down = share_of(y + i, info->height, out->height);
            decode_row(job, job->rows + i * pitch);
            add_row(job, down.first, out->texels + down.cell * stride);
            if (down.second > 0.0f)
                add_row(job, down.second, out->texels + (down.cell + 1) * stride);
        }
    }
    return 0;
}

static void choose_size(const img_info *info, uint64_t max_texels, uint32_t *width, uint32_t *height) {
    double texels = (double)info->width * info->height;
    double scale = texels > (double)max_texels ? sqrt((double)max_texels / texels) : 1.0;
    *width = (uint32_t)fmax(1.0, floor(info->width * scale));
    *height = (uint32_t)fmax(1.0, floor(info->height * scale));
}

static author_result load_open(linear_job *job, uint64_t max_texels, author_picture *out, char *error) {
    const img_info *info = job->info;
    author_run run = {0};
    uint32_t width, height;
    choose_size(info, max_texels, &width, &height);
    job->channels = info->channels < 3 ? 1 : 3;
    job->transfer = info->transfer;
    if (!zt_transfer_known(job->transfer))
        job->transfer = info->type == IMG_U8 || info->type == IMG_U16 ? SRGB : 8;
    for (int i = 0; i < 256; i++)
        job->table[i] = zt_transfer_decode(job->transfer, (float)i / 255.0f);
    job->rows = malloc((size_t)info->width * BAND * job->channels * sizeof(float));
    job->line = malloc((size_t)info->width * job->channels * sizeof(float));
    job->across = malloc((size_t)info->width * sizeof *job->across);
    author_result result = author_picture_create(&run, width, height, job->channels, out);
    if (result != AUTHOR_OK || !job->rows || !job->line || !job->across) {
        snprintf(error, IMG_ERROR, "out of memory");
        return AUTHOR_NO_MEMORY;
    }
    for (uint32_t x = 0; x < info->width; x++)
        job->across[x] = share_of(x, info->width, width);
    return reduce(job, out, error) ? AUTHOR_BAD_INPUT : AUTHOR_OK;
}

author_result load_linear(const char *path, uint64_t max_texels, author_picture *out, char *error) {
    linear_job job = {0};
    *out = (author_picture){0};
    job.reader = img_open(path, NULL, error);
    if (!job.reader)
        return AUTHOR_BAD_INPUT;
    job.info = img_get_info(job.reader);
    author_result result = load_open(&job, max_texels, out, error);
    if (result != AUTHOR_OK)
        author_picture_release(out);
    free(job.rows);
    free(job.line);
    free(job.across);
    img_close(job.reader);
    return result;
}

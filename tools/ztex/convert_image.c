/* SPDX-License-Identifier: Apache-2.0 */
/* One image from file to file: tiles as they are stored, or rows of texels in bands. */
#include "convert.h"

#include <stdlib.h>

#define BAND_BYTES (UINT64_C(8) << 20)

static int fail(const convert_job *job, zt_result result, const zt_diag *diag) {
    return cmd_fail_result(job->input.name, result, diag);
}

uint64_t convert_image_size(const convert_job *job, uint32_t image) {
    zt_image_info info;
    uint64_t bytes = 0;
    if (zt_get_image(job->input.file, image, &info) != ZT_OK)
        return 0;
    for (uint32_t k = 0; k < info.levels; k++) {
        zt_level_info level;
        if (zt_get_level(job->input.file, image, k, &level) == ZT_OK)
            bytes += level.level_size;
    }
    return bytes;
}

static int step(convert_job *job, uint64_t bytes) {
    job->bytes_done += bytes;
    double done = (double)job->bytes_done / ((double)job->bytes_total + 1.0);
    return cmd_progress_step(&job->progress, done < 1.0 ? done : 1.0) ? cmd_cancelled() : CMD_OK;
}

/* ---- tiles ------------------------------------------------------------------------------------------------ */

typedef struct tile_buffer {
    unsigned char *data;
    size_t size;
} tile_buffer;

static int copy_tile(convert_job *job, uint32_t image, uint32_t level, uint64_t tile, tile_buffer *buffer) {
    zt_diag diag = {.offset = UINT64_MAX};
    zt_tile_info info;
    zt_result result = zt_get_tile(job->input.file, image, level, tile, &info, &diag);
    if (result != ZT_OK)
        return fail(job, result, &diag);
    if (info.stored_size > buffer->size) {
        unsigned char *data = realloc(buffer->data, info.stored_size);
        if (!data)
            return cmd_fail(CMD_INTERNAL, "%s: out of memory", job->input.name);
        *buffer = (tile_buffer){data, info.stored_size};
    }
    result = zt_read_tile(job->input.file, image, level, tile, buffer->data, info.stored_size, &diag);
    if (result == ZT_OK)
        result = zt_writer_put_stored_tile(job->writer, job->images[image], level, tile, info.codec, info.hash,
                                           buffer->data, info.stored_size, &diag);
    if (result != ZT_OK)
        return fail(job, result, &diag);
    job->tiles_copied++;
    return step(job, info.decoded_size);
}

static int copy_tiles(convert_job *job, uint32_t image, const convert_plan *plan) {
    tile_buffer buffer = {0};
    int status = CMD_OK;
    uint32_t tail = plan->from.tail_level;
    for (uint32_t k = 0; status == CMD_OK && k < plan->from.levels && k <= tail; k++) {
        zt_level_info level;
        if (zt_get_level(job->input.file, image, k, &level) != ZT_OK)
            status = cmd_fail(CMD_INTERNAL, "%s: there is no level %u", job->input.name, (unsigned)k);
        for (uint64_t tile = 0; status == CMD_OK && tile < level.tile_count; tile++)
            status = copy_tile(job, image, k, tile, &buffer);
    }
    free(buffer.data);
    return status;
}

/* ---- rows ------------------------------------------------------------------------------------------------- */

typedef struct row_bands {
    convert_job *job;
    const convert_plan *plan;
    uint32_t image, rows;
    unsigned char *from, *to;
    float *rgba;
} row_bands;

static void recode(const row_bands *b, size_t count) {
    uint32_t now = b->plan->from.transfer, then = b->plan->to.transfer;
    zt_unpack_texels(b->plan->from.format, b->from, count, b->rgba);
    for (size_t i = 0; now != then && i < 4 * count; i++)
        if (i % 4 < 3)
            b->rgba[i] = zt_transfer_encode(then, zt_transfer_decode(now, b->rgba[i]));
    zt_pack_texels(b->plan->to.format, b->rgba, count, b->to);
}

static int copy_band(row_bands *b, zt_region region, const zt_level_info *level) {
    const zt_image_info *info = &b->plan->from;
    zt_decode_options how = {.size = sizeof how, .parallel = cmd_parallel(b->job->args)};
    zt_diag diag = {.offset = UINT64_MAX};
    uint32_t rows = (region.height + info->block_height - 1) / info->block_height;
    size_t size = rows * (size_t)level->row_size;
    zt_result result = zt_decode_region(b->job->input.file, b->image, &region, b->from, size, 0, 0, &how, &diag);
    if (result != ZT_OK)
        return fail(b->job, result, &diag);
    if (b->plan->reformat)
        recode(b, (size_t)region.width * region.height);
    const unsigned char *data = b->plan->reformat ? b->to : b->from;
    uint32_t image = b->job->images[b->image];
    if (b->plan->to.given_levels)
        result = zt_writer_put_level_rows(b->job->writer, image, region.level, data, rows, 0, &diag);
    else
        result = zt_writer_put_rows(b->job->writer, image, data, rows, 0, &diag);
    return result == ZT_OK ? step(b->job, size) : fail(b->job, result, &diag);
}

static int copy_level(row_bands *b, uint32_t k) {
    zt_level_info level;
    uint32_t step_rows = b->rows * b->plan->from.block_height;
    if (zt_get_level(b->job->input.file, b->image, k, &level) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "%s: there is no level %u", b->job->input.name, (unsigned)k);
    uint64_t slices = (uint64_t)b->plan->from.layers * level.depth;
    for (uint64_t s = 0; s < slices; s++) {
        zt_region region = {.level = k, .layer = (uint32_t)(s / level.depth), .z = (uint32_t)(s % level.depth)};
        region.width = level.width;
        region.depth = 1;
        for (uint32_t y = 0; y < level.height; y += region.height) {
            region.y = y;
            region.height = level.height - y < step_rows ? level.height - y : step_rows;
            int status = copy_band(b, region, &level);
            if (status != CMD_OK)
                return status;
        }
    }
    return CMD_OK;
}

static int copy_rows(convert_job *job, uint32_t image, const convert_plan *plan) {
    row_bands b = {.job = job, .plan = plan, .image = image, .rows = plan->from.tile_edge};
    zt_level_info level;
    int status = CMD_OK;
    if (zt_get_level(job->input.file, image, 0, &level) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "%s: there is no image %u", job->input.name, (unsigned)image);
    while (b.rows > 16 && b.rows * level.row_size > BAND_BYTES)
        b.rows /= 2;
    b.rows = b.rows > level.blocks_y ? level.blocks_y : b.rows;
    size_t texels = (size_t)level.width * b.rows;
    const zt_format_info *to = zt_find_format(plan->to.format);
    b.from = malloc(b.rows * (size_t)level.row_size);
    if (plan->reformat && to) {
        b.to = malloc(texels * to->block_bytes);
        b.rgba = malloc(texels * 4 * sizeof *b.rgba);
    }
    if (!b.from || (plan->reformat && (!b.to || !b.rgba)))
        status = cmd_fail(CMD_INTERNAL, "%s: out of memory", job->input.name);
    uint32_t levels = plan->to.given_levels ? plan->to.levels : 1;
    for (uint32_t k = 0; status == CMD_OK && k < levels; k++)
        status = copy_level(&b, k);
    free(b.from);
    free(b.to);
    free(b.rgba);
    return status;
}

int convert_copy_image(convert_job *job, uint32_t image) {
    convert_plan plan;
    zt_diag diag = {.offset = UINT64_MAX};
    int status = convert_plan_image(job, image, &plan);
    if (status != CMD_OK)
        return status;
    zt_result result = zt_writer_add_image(job->writer, &plan.to, &diag, &job->images[image]);
    if (result != ZT_OK)
        return fail(job, result, &diag);
    return plan.stored ? copy_tiles(job, image, &plan) : copy_rows(job, image, &plan);
}

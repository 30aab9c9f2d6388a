/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Question: how long does a whole texture, 4096 x 4096 RGBA8 with all levels, take from the bytes of its file into
 * memory that can be uploaded, against one zstd frame at level 19 for each level?
 *
 * The texture is an atlas of the set's pictures of 1024 x 1024 RGBA8, no two alike while there are enough. In memory
 * the levels stand from the coarsest to the finest.
 */
#include <stdlib.h>
#include <string.h>

#include <zstd.h>
#include <zt/zt_write.h>

#include "codec.h"
#include "codec_zt.h"

enum { EDGE = 4096, CELL = 1024, CELLS = EDGE / CELL, LEVELS = 13, RGBA8 = 37, MAX_ROUNDS = 99 };

typedef struct {
    codec_bytes file, frames[LEVELS];
    size_t offset[LEVELS], level_size[LEVELS], size; /* of the levels in memory */
    unsigned char *texels, *ours, *peer;
    ZSTD_DCtx *context;
} load_job;

static unsigned make_atlas(const codec_picture *pictures, size_t count, unsigned char *texels) {
    const codec_picture *cells[CELLS * CELLS];
    unsigned found = 0;
    for (size_t i = 0; i < count && found < CELLS * CELLS; i++) {
        const codec_picture *p = &pictures[i];
        if (p->width == CELL && p->height == CELL && p->channels == 4 && p->channel_bytes == 1)
            cells[found++] = p;
    }
    for (unsigned i = 0; found > 0 && i < CELLS * CELLS; i++) {
        unsigned char *to = texels + ((size_t)(i / CELLS) * CELL * EDGE + (size_t)(i % CELLS) * CELL) * 4;
        for (size_t y = 0; y < CELL; y++)
            memcpy(to + y * EDGE * 4, cells[i % found]->texels + y * CELL * 4, (size_t)CELL * 4);
    }
    return found;
}

static int load_ours(const load_job *job, unsigned char *to, int threads) {
    zt_diag diag = {0};
    zt_file *file = NULL;
    zt_image_info image;
    zt_tile_info tail;
    zt_decode_options options = {.parallel = codec_zt_parallel(threads)};
    zt_result result = zt_open_memory(job->file.data, job->file.size, NULL, &diag, &file);
    if (result == ZT_OK)
        result = zt_get_image(file, 0, &image);
    /* The tail's levels stand together, the coarsest first, as they do in this memory. */
    if (result == ZT_OK && image.tail_level < image.levels) {
        result = zt_get_tile(file, 0, image.tail_level, 0, &tail, &diag);
        if (result == ZT_OK)
            result = zt_decode_tile(file, 0, image.tail_level, 0, to, tail.decoded_size, &diag);
    }
    for (uint32_t level = 0; result == ZT_OK && level < image.tail_level; level++)
        result = zt_decode_level(file, 0, level, 0, to + job->offset[level], job->level_size[level], 0, &options,
                                 &diag);
    zt_close(file);
    if (result != ZT_OK)
        fprintf(stderr, "ztex: %s\n", diag.text);
    return result == ZT_OK;
}

static int load_peer(const load_job *job, unsigned char *to) {
    for (int level = 0; level < LEVELS; level++) {
        size_t size = job->level_size[level];
        if (ZSTD_decompressDCtx(job->context, to + job->offset[level], size, job->frames[level].data,
                                job->frames[level].size) != size)
            return 0;
    }
    return 1;
}

/* The texels of all levels come from the file, so both sides hold the same. */
static int make_files(load_job *job) {
    zt_diag diag = {0};
    zt_file *file = NULL;
    zt_writer_options options = codec_zt_options(CODEC_EFFORT_DEFAULT, codec_zt_parallel(2));
    zt_image_desc desc = {.format = RGBA8, .width = EDGE, .height = EDGE, .alpha_mode = ZT_ALPHA_STRAIGHT};
    if (!codec_zt_write(&desc, job->texels, EDGE, &options, &job->file) ||
        zt_open_memory(job->file.data, job->file.size, NULL, &diag, &file) != ZT_OK)
        return 0;
    int done = 1;
    for (int level = 0; level < LEVELS && done; level++) {
        size_t size = job->level_size[level], bound = ZSTD_compressBound(size);
        unsigned char *texels = job->texels + job->offset[level];
        codec_bytes *frame = &job->frames[level];
        done = codec_reserve(frame, bound) &&
               zt_decode_level(file, 0, (uint32_t)level, 0, texels, size, 0, NULL, &diag) == ZT_OK;
        if (done)
            frame->size = ZSTD_compress(frame->data, bound, texels, size, 19);
        done = done && !ZSTD_isError(frame->size);
    }
    zt_close(file);
    return done;
}

static int measure(const load_job *job, unsigned rounds, codec_load *out) {
    double times[5][MAX_ROUNDS];
    for (unsigned r = 0; r < rounds; r++) {
        double wall = codec_wall_seconds(), cpu = codec_cpu_seconds();
        if (!load_ours(job, job->ours, 0))
            return 0;
        times[0][r] = codec_cpu_seconds() - cpu;
        times[1][r] = codec_wall_seconds() - wall;
        cpu = codec_cpu_seconds();
        if (!load_peer(job, job->peer))
            return 0;
        times[2][r] = codec_cpu_seconds() - cpu;
        if (r == 0 &&
            (memcmp(job->ours, job->texels, job->size) != 0 || memcmp(job->peer, job->texels, job->size) != 0))
            return 0;
        wall = codec_wall_seconds();
        if (!load_ours(job, job->ours, 2))
            return 0;
        times[3][r] = codec_wall_seconds() - wall;
        cpu = codec_cpu_seconds();
        memcpy(job->ours, job->texels, job->size);
        times[4][r] = codec_cpu_seconds() - cpu;
    }
    out->ours_cpu = codec_median(times[0], rounds);
    out->ours_wall = codec_median(times[1], rounds);
    out->peer_cpu = codec_median(times[2], rounds);
    out->ours_wall_2 = codec_median(times[3], rounds);
    out->copy_cpu = codec_median(times[4], rounds);
    return 1;
}

static void release(load_job *job) {
    for (int level = 0; level < LEVELS; level++)
        free(job->frames[level].data);
    free(job->file.data);
    free(job->texels);
    free(job->ours);
    free(job->peer);
    ZSTD_freeDCtx(job->context);
}

int codec_load_test(const codec_picture *pictures, size_t count, unsigned rounds, codec_load *out) {
    load_job job = {0};
    for (int level = LEVELS - 1; level >= 0; level--) {
        job.level_size[level] = (size_t)(EDGE >> level) * (size_t)(EDGE >> level) * 4;
        job.offset[level] = job.size;
        job.size += job.level_size[level];
    }
    job.texels = malloc(job.size);
    job.ours = malloc(job.size);
    job.peer = malloc(job.size);
    job.context = ZSTD_createDCtx();
    int done = job.texels && job.ours && job.peer && job.context;
    if (done) {
        memset(job.ours, 0xA5, job.size); /* the system's zero pages are not part of the question */
        memset(job.peer, 0xA5, job.size);
        out->sources = make_atlas(pictures, count, job.texels);
    }
    done = done && out->sources > 0 && make_files(&job) && measure(&job, rounds, out);
    out->there = done;
    out->texels = job.size;
    out->ours = job.file.size;
    out->peer = codec_ktx2_overhead(LEVELS, 4);
    for (int level = 0; level < LEVELS; level++)
        out->peer += job.frames[level].size;
    release(&job);
    if (!done)
        fprintf(stderr, "the loading test failed\n");
    return done;
}

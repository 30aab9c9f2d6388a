/* SPDX-License-Identifier: Apache-2.0 */
/* Ours: a .ztex file of one image with one level, written to memory and decoded from memory. */
#define _GNU_SOURCE /* for the affinity of threads */
#include <sched.h>
#include <string.h>

#include <zt/zt_write.h>

#include "codec.h"
#include "codec_zt.h"

static zt_result append(void *user, const void *data, size_t size) {
    return codec_append(user, data, size) ? ZT_OK : ZT_IO;
}

zt_writer_options codec_zt_options(int effort, const zt_parallel *parallel) {
    return (zt_writer_options){.parallel = parallel, .effort = effort};
}

/* The calling thread goes to the first processor, the other one to the last: some systems leave both on one for as long
 * as decoding a few pictures takes. A thread begins where the one that makes it is. */
static zt_result open_pool(zt_threads **out) {
    cpu_set_t allowed, one;
    int first = 0, last = CPU_SETSIZE - 1;
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0 || CPU_COUNT(&allowed) < 2)
        return zt_threads_open(2, out);
    while (!CPU_ISSET((size_t)first, &allowed))
        first++;
    while (!CPU_ISSET((size_t)last, &allowed))
        last--;
    CPU_ZERO(&one);
    CPU_SET((size_t)last, &one);
    sched_setaffinity(0, sizeof one, &one);
    zt_result result = zt_threads_open(2, out);
    CPU_ZERO(&one);
    CPU_SET((size_t)first, &one);
    sched_setaffinity(0, sizeof one, &one);
    return result;
}

const zt_parallel *codec_zt_parallel(int threads) {
    static zt_threads *pool;
    static zt_parallel parallel;
    if (threads == 2 && !pool && open_pool(&pool) == ZT_OK)
        parallel = zt_threads_parallel(pool);
    return threads == 2 ? &parallel : NULL;
}

int codec_zt_write(const zt_image_desc *desc, const void *texels, uint32_t rows, const zt_writer_options *options,
                   codec_bytes *out) {
    zt_diag diag = {0};
    zt_writer *writer = NULL;
    zt_sink sink = {.user = out, .write = append};
    uint32_t image = 0;
    out->size = 0;
    zt_result result = zt_writer_open_sink(&sink, options, &diag, &writer);
    if (result == ZT_OK)
        result = zt_writer_add_image(writer, desc, &diag, &image);
    if (result == ZT_OK)
        result = zt_writer_put_rows(writer, image, texels, rows, 0, &diag);
    if (result == ZT_OK)
        result = zt_writer_add_texture(writer, &(zt_texture_desc){.name = "picture", .image = image}, &diag, NULL);
    if (result == ZT_OK)
        result = zt_writer_finish(writer, &diag);
    zt_writer_close(writer);
    if (result != ZT_OK)
        fprintf(stderr, "ztex: %s\n", diag.text);
    return result == ZT_OK;
}

static uint32_t format_of(const codec_picture *picture) {
    if (picture->channel_bytes == 2)
        return 97;                                                        /* R16G16B16A16_SFLOAT */
    return picture->channels == 1 ? 9 : picture->channels == 3 ? 23 : 37; /* R8, R8G8B8, R8G8B8A8_UNORM */
}

int codec_zt_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    zt_writer_options options = codec_zt_options(self->level, codec_zt_parallel(self->threads));
    zt_image_desc desc = {.format = format_of(picture),
                          .width = picture->width,
                          .height = picture->height,
                          .levels = 1,
                          .tile_edge = self->edge,
                          .alpha_mode = picture->channels == 4 ? ZT_ALPHA_STRAIGHT : ZT_ALPHA_NONE};
    return codec_zt_write(&desc, picture->texels, picture->height, &options, out);
}

static int decode_to(const codec_picture *picture, const codec_bytes *in, const zt_parallel *parallel, void *texels) {
    zt_diag diag = {0};
    zt_file *file = NULL;
    zt_decode_options options = {.parallel = parallel};
    zt_result result = zt_open_memory(in->data, in->size, NULL, &diag, &file);
    if (result == ZT_OK)
        result = zt_decode_level(file, 0, 0, 0, texels, picture->size, 0, &options, &diag);
    zt_close(file);
    if (result != ZT_OK)
        fprintf(stderr, "ztex: %s\n", diag.text);
    return result == ZT_OK;
}

int codec_zt_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    return decode_to(picture, in, codec_zt_parallel(self->threads), texels);
}

typedef struct {
    const codec_picture *picture;
    const codec_bytes *in;
    void *texels[2];
    int done[2];
} both_job;

static void decode_one_of_both(void *context, size_t index, unsigned worker) {
    both_job *job = context;
    (void)worker;
    job->done[index] = decode_to(job->picture, job->in, NULL, job->texels[index]);
}

int codec_zt_both_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in,
                         void *texels) {
    static codec_bytes other; /* texels of the second thread, kept for all pictures */
    const zt_parallel *parallel = codec_zt_parallel(self->threads);
    if (picture->size > other.size) {
        if (!codec_reserve(&other, picture->size))
            return 0;
        memset(other.data, 0xA5, picture->size); /* the system's zero pages are not part of the question */
        other.size = picture->size;
    }
    both_job job = {.picture = picture, .in = in, .texels = {texels, other.data}};
    parallel->run(parallel->user, 2, decode_one_of_both, &job);
    return job.done[0] && job.done[1];
}

/* SPDX-License-Identifier: Apache-2.0 */
/* memcpy, and the way of KTX2: one zstd frame for the whole level. */
#include <string.h>

#include <zstd.h>

#include "codec.h"

int codec_copy_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    (void)self;
    out->size = 0;
    return codec_append(out, picture->texels, picture->size);
}

int codec_copy_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    (void)self;
    memcpy(texels, in->data, picture->size);
    return 1;
}

size_t codec_ktx2_overhead(unsigned levels, unsigned channels) {
    enum { HEADER = 80, LEVEL = 24, DESCRIPTOR = 28, SAMPLE = 16 };
    return HEADER + LEVEL * (size_t)levels + DESCRIPTOR + SAMPLE * (size_t)channels;
}

/* The contexts are made once, as a loader of many textures would. */
int codec_zstd_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    static ZSTD_CCtx *context;
    size_t bound = ZSTD_compressBound(picture->size), head = codec_ktx2_overhead(1, picture->channels);
    if (!context)
        context = ZSTD_createCCtx();
    if (!context || !codec_reserve(out, head + bound))
        return 0;
    memset(out->data, 0, head);
    size_t size = ZSTD_compressCCtx(context, out->data + head, bound, picture->texels, picture->size, self->level);
    if (ZSTD_isError(size)) {
        fprintf(stderr, "zstd: %s\n", ZSTD_getErrorName(size));
        return 0;
    }
    out->size = head + size;
    return 1;
}

int codec_zstd_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    static ZSTD_DCtx *context;
    size_t head = codec_ktx2_overhead(1, picture->channels);
    (void)self;
    if (!context)
        context = ZSTD_createDCtx();
    return context &&
           ZSTD_decompressDCtx(context, texels, picture->size, in->data + head, in->size - head) == picture->size;
}

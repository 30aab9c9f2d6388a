/* SPDX-License-Identifier: Apache-2.0 */
/* The zstd profile (spec/ztex.md section 6.1) and stored bytes of chunks and tiles. */
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>
#include <zstd_errors.h>

#include "base_bytes.h"
#include "base_hash.h"
#include "file_codec.h"
#include "file_pred_frame.h"

enum {
    FRAME_BLOCK_MAX = 131072,
    FRAME_SINGLE_SEGMENT = 0x20,
    FRAME_FORBIDDEN = 0x1F, /* unused bit, reserved bit, checksum flag, dictionary id flag */
    BLOCK_RLE = 1,
    BLOCK_RESERVED = 3,
    ALLOC_HEADER = 16 /* keeps zstd's blocks aligned like malloc's */
};

static uint64_t place_of(uint64_t offset, size_t at) {
    return offset == ZT__NO_OFFSET ? ZT__NO_OFFSET : offset + at;
}

/* ---- decoding ---------------------------------------------------------------------------- */

void zt__decoder_init(zt__decoder *decoder, zt__memory *memory) {
    zt__decoder empty = {0};
    *decoder = empty;
    decoder->memory = memory;
    decoder->kernel = zt__pred_kernel_best();
}

void zt__decoder_free(zt__decoder *decoder) {
    if (!decoder->memory)
        return;
    zt__free(decoder->memory, decoder->zstd, decoder->zstd_size, 1);
    zt__free(decoder->memory, decoder->stored, decoder->stored_size, 1);
    zt__free(decoder->memory, decoder->raw, decoder->raw_size, 1);
    zt__free(decoder->memory, decoder->scratch, decoder->scratch_size, 1);
    zt__decoder_init(decoder, decoder->memory);
}

static zt_result buffer_of(zt__memory *memory, void **buffer, uint64_t *have, uint64_t size, zt_diag *diag,
                           uint8_t **out) {
    *out = NULL;
    if (size == 0)
        size = 1;
    if (*have < size) {
        zt__free(memory, *buffer, *have, 1);
        *buffer = NULL;
        *have = 0;
        ZT_TRY(zt__alloc_raw(memory, size, 1, diag, buffer));
        *have = size;
    }
    *out = *buffer;
    return ZT_OK;
}

zt_result zt__decoder_stored(zt__decoder *decoder, uint64_t size, zt_diag *diag, uint8_t **out) {
    return buffer_of(decoder->memory, &decoder->stored, &decoder->stored_size, size, diag, out);
}

zt_result zt__decoder_raw(zt__decoder *decoder, uint64_t size, zt_diag *diag, uint8_t **out) {
    return buffer_of(decoder->memory, &decoder->raw, &decoder->raw_size, size, diag, out);
}

void zt__decoder_reserve(zt__decoder *decoder, uint64_t size) {
    uint8_t *scratch;
    (void)buffer_of(decoder->memory, &decoder->scratch, &decoder->scratch_size, size, NULL, &scratch);
}

/* The frame content size field of a single-segment frame, its length by the top two bits. */
static uint64_t content_size(zt__cursor *in, unsigned flag) {
    switch (flag) {
    case 0:
        return zt__take8(in);
    case 1:
        return (uint64_t)zt__take16(in) + 256;
    case 2:
        return zt__take32(in);
    default:
        return zt__take64(in);
    }
}

static zt_result check_blocks(zt__sink *sink, zt__cursor *in, uint64_t offset) {
    bool last = false;
    while (!last) {
        uint64_t place = place_of(offset, in->at);
        const uint8_t *p = zt__take(in, 3);
        if (!p)
            return zt__report(sink, 5003, place, "the zstd frame ends before its last block");
        uint32_t head = p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16;
        uint32_t type = head >> 1 & 3, size = head >> 3;
        last = head & 1;
        if (type == BLOCK_RESERVED)
            return zt__report(sink, 5003, place, "a zstd block has the reserved type 3");
        if (size > FRAME_BLOCK_MAX)
            return zt__report(sink, 5003, place, "a zstd block has the size %u, above 131072", (unsigned)size);
        if (!zt__take(in, type == BLOCK_RLE ? 1 : size))
            return zt__report(sink, 5003, place, "a zstd block goes beyond the stored bytes");
    }
    if (zt__left(in) != 0)
        return zt__report(sink, 5003, place_of(offset, in->at), "%llu bytes follow the last zstd block",
                          (unsigned long long)zt__left(in));
    return ZT_OK;
}

zt_result zt__check_frame(zt__sink *sink, const uint8_t *frame, size_t size, uint64_t decoded_size, uint64_t offset) {
    zt__cursor in = zt__cursor_of(frame, size);
    uint32_t magic = zt__take32(&in);
    if (in.bad || magic != ZSTD_MAGICNUMBER)
        return zt__report(sink, 5001, offset, "no zstd frame begins here");
    uint8_t descriptor = zt__take8(&in);
    if (in.bad || !(descriptor & FRAME_SINGLE_SEGMENT) || (descriptor & FRAME_FORBIDDEN))
        return zt__report(sink, 5001, place_of(offset, 4),
                          "the zstd frame header descriptor 0x%02X is outside the profile", (unsigned)descriptor);
    uint64_t content = content_size(&in, descriptor >> 6);
    if (in.bad || content != decoded_size)
        return zt__report(sink, 5002, place_of(offset, 5), "the zstd frame has a content size of %llu instead of %llu",
                          (unsigned long long)content, (unsigned long long)decoded_size);
    return check_blocks(sink, &in, offset);
}

/* zstd's decoder in memory of ours: it never calls malloc. */
static zt_result dctx_of(zt__decoder *decoder, zt_diag *diag, ZSTD_DCtx **out) {
    *out = NULL;
    if (!decoder->zstd) {
        size_t size = ZSTD_estimateDCtxSize();
        ZT_TRY(zt__alloc_raw(decoder->memory, size, 1, diag, &decoder->zstd));
        decoder->zstd_size = size;
    }
    *out = ZSTD_initStaticDCtx(decoder->zstd, decoder->zstd_size);
    if (!*out)
        return zt__fail(diag, ZT_INTERNAL, 0, ZT__NO_OFFSET, "zstd refused its workspace");
    return ZT_OK;
}

zt_result zt__decode_frame(zt__sink *sink, zt__decoder *decoder, const uint8_t *frame, size_t size, void *dst,
                           size_t dst_size, uint64_t offset) {
    ZT_TRY(zt__check_frame(sink, frame, size, dst_size, offset));
    ZSTD_DCtx *dctx;
    ZT_TRY(dctx_of(decoder, sink->diag, &dctx));
    size_t got = ZSTD_decompressDCtx(dctx, dst, dst_size, frame, size);
    if (ZSTD_isError(got))
        return zt__report(sink, 5004, offset, "the zstd frame is damaged: %s", ZSTD_getErrorName(got));
    if (got != dst_size)
        return zt__report(sink, 5004, offset, "the zstd frame decodes to %llu bytes instead of %llu",
                          (unsigned long long)got, (unsigned long long)dst_size);
    return ZT_OK;
}

zt_result zt__decode_stored(zt__sink *sink, zt__decoder *decoder, uint8_t codec, const uint8_t *stored, size_t size,
                            void *dst, size_t dst_size, uint64_t hash, uint32_t hash_rule, uint64_t offset) {
    if (codec == ZT__CODEC_ZSTD) {
        ZT_TRY(zt__decode_frame(sink, decoder, stored, size, dst, dst_size, offset));
    } else if (codec != ZT__CODEC_RAW) {
        return zt__fail(sink->diag, ZT_UNSUPPORTED, 0, offset, "codec %u is not known", (unsigned)codec);
    } else {
        if (size != dst_size)
            return zt__fail(sink->diag, ZT_INTERNAL, 0, offset, "raw bytes of another size");
        memcpy(dst, stored, dst_size);
    }
    ZT_RULE(sink, hash_rule, zt__hash(dst, dst_size) == hash, offset,
            "the decoded bytes do not have the hash that is stored for them");
    return ZT_OK;
}

/* Samples that are words of the range coder. *hash: of the texels. */
static zt_result decode_words(zt__sink *sink, zt__decoder *decoder, const zt__pred_shape *shape, const uint8_t *stored,
                              size_t size, uint8_t *dst, size_t pitch, uint64_t offset, uint64_t *hash) {
    uint8_t *scratch;
    ZT_TRY(buffer_of(decoder->memory, &decoder->scratch, &decoder->scratch_size, zt__pred_scratch_size(shape),
                     sink->diag, &scratch));
    uint32_t broken = zt__pred_decode_hashed(decoder->kernel, shape, stored, size, scratch, dst, pitch, hash);
    if (broken)
        return zt__report(sink, broken, offset, "the tile is damaged: %s", zt__find_rule(broken)->pub.text);
    return ZT_OK;
}

/* Samples that are a zstd frame. */
static zt_result decode_samples(zt__sink *sink, zt__decoder *decoder, const zt__pred_shape *shape,
                                const uint8_t *stored, size_t size, uint8_t *dst, size_t pitch, uint64_t offset,
                                uint64_t *hash) {
    uint8_t *samples;
    zt__pred_form form;
    zt__hasher hasher;
    size_t row_size = (size_t)shape->width * shape->channels * shape->channel_bytes,
           raw_size = row_size * shape->height;
    uint32_t broken = zt__pred_take_form(shape, stored, size, &form);
    if (broken)
        return zt__report(sink, broken, offset, "the tile is damaged: %s", zt__find_rule(broken)->pub.text);
    ZT_TRY(buffer_of(decoder->memory, &decoder->scratch, &decoder->scratch_size, raw_size, sink->diag, &samples));
    ZT_TRY(zt__decode_frame(sink, decoder, stored + ZT__PRED_FORM_SIZE, size - ZT__PRED_FORM_SIZE, samples, raw_size,
                            place_of(offset, ZT__PRED_FORM_SIZE)));
    zt__hash_begin(&hasher);
    zt__pred_from_samples(decoder->kernel, shape, &form, samples, dst, pitch, &hasher);
    *hash = zt__hash_end(&hasher);
    return ZT_OK;
}

zt_result zt__decode_pred(zt__sink *sink, zt__decoder *decoder, const zt__pred_shape *shape, const uint8_t *stored,
                          size_t size, uint8_t *dst, size_t pitch, uint64_t hash, uint64_t offset) {
    uint64_t found;
    if (!zt__pred_shape_ok(shape))
        return zt__fail(sink->diag, ZT_INTERNAL, 0, offset, "a tile that codec 2 is not for");
    if (zt__pred_has_frame(stored, size))
        ZT_TRY(decode_samples(sink, decoder, shape, stored, size, dst, pitch, offset, &found));
    else
        ZT_TRY(decode_words(sink, decoder, shape, stored, size, dst, pitch, offset, &found));
    ZT_RULE(sink, 5203, found == hash, offset, "the decoded bytes do not have the hash that is stored for them");
    return ZT_OK;
}

zt_result zt__decode_fields(zt__sink *sink, zt__decoder *decoder, const zt__fields *fields, size_t row_size,
                            size_t row_count, const uint8_t *stored, size_t size, uint8_t *dst, size_t pitch,
                            uint64_t hash, uint64_t offset) {
    uint8_t *apart;
    zt__hasher hasher;
    size_t raw_size = row_size * row_count;
    if (!fields)
        return zt__fail(sink->diag, ZT_INTERNAL, 0, offset, "a tile that codec 4 is not for");
    ZT_TRY(buffer_of(decoder->memory, &decoder->scratch, &decoder->scratch_size, raw_size, sink->diag, &apart));
    ZT_TRY(zt__decode_frame(sink, decoder, stored, size, apart, raw_size, offset));
    size_t count = raw_size / fields->block_bytes, across = row_size / fields->block_bytes;
    zt__hash_begin(&hasher);
    for (size_t y = 0; y < row_count; y++) {
        zt__fields_together(fields, apart, count, y * across, across, dst + y * pitch);
        zt__hash_more(&hasher, dst + y * pitch, row_size);
    }
    ZT_RULE(sink, 5203, zt__hash_end(&hasher) == hash, offset,
            "the decoded bytes do not have the hash that is stored for them");
    return ZT_OK;
}

/* ---- encoding ---------------------------------------------------------------------------- */

/* zstd frees without saying how much, so each block remembers its size. */
static void *zstd_alloc(void *opaque, size_t size) {
    void *block;
    if (size > SIZE_MAX - ALLOC_HEADER)
        return NULL;
    size_t whole = size + ALLOC_HEADER;
    if (zt__alloc_raw(opaque, whole, 1, NULL, &block) != ZT_OK)
        return NULL;
    memcpy(block, &whole, sizeof whole);
    return (uint8_t *)block + ALLOC_HEADER;
}

static void zstd_free(void *opaque, void *address) {
    if (!address)
        return;
    size_t whole;
    uint8_t *block = (uint8_t *)address - ALLOC_HEADER;
    memcpy(&whole, block, sizeof whole);
    zt__free(opaque, block, whole, 1);
}

zt_result zt__encoder_init(zt__encoder *encoder, zt__memory *memory, int level, bool raw_only, zt_diag *diag) {
    zt__encoder empty = {0};
    *encoder = empty;
    encoder->memory = memory;
    encoder->level = level;
    encoder->raw_only = raw_only;
    ZSTD_customMem custom = {zstd_alloc, zstd_free, memory};
    encoder->zstd = ZSTD_createCCtx_advanced(custom);
    if (!encoder->zstd)
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "no memory for a zstd encoder");
    return ZT_OK;
}

void zt__encoder_free(zt__encoder *encoder) {
    if (encoder->memory)
        zt__free(encoder->memory, encoder->pred, encoder->pred_size, 1);
    encoder->pred = NULL;
    encoder->pred_size = 0;
    ZSTD_freeCCtx(encoder->zstd);
    encoder->zstd = NULL;
}

zt_result zt__encoder_memory(zt__encoder *encoder, uint64_t size, zt_diag *diag, uint8_t **out) {
    return buffer_of(encoder->memory, &encoder->pred, &encoder->pred_size, size, diag, out);
}

size_t zt__encode_bound(size_t size) {
    return ZSTD_compressBound(size);
}

static size_t set_parameter(ZSTD_CCtx *cctx, ZSTD_cParameter parameter, int value, size_t before) {
    return ZSTD_isError(before) ? before : ZSTD_CCtx_setParameter(cctx, parameter, value);
}

/* A window over all of the source is what makes the frame single-segment. */
static int window_log(int level, size_t size) {
    ZSTD_compressionParameters usual = ZSTD_getCParams(level, size, 0);
    if (size <= (size_t)1 << usual.windowLog)
        return 0;
    int log = (int)usual.windowLog;
    while (log < ZSTD_WINDOWLOG_MAX && (size_t)1 << log < size)
        log++;
    return log;
}

static size_t compress(const zt__encoder *encoder, const void *src, size_t size, void *dst, size_t dst_size) {
    ZSTD_CCtx *cctx = encoder->zstd;
    size_t r = ZSTD_CCtx_reset(cctx, ZSTD_reset_session_and_parameters);
    r = set_parameter(cctx, ZSTD_c_compressionLevel, encoder->level, r);
    r = set_parameter(cctx, ZSTD_c_contentSizeFlag, 1, r);
    r = set_parameter(cctx, ZSTD_c_checksumFlag, 0, r);
    r = set_parameter(cctx, ZSTD_c_dictIDFlag, 0, r);
    r = set_parameter(cctx, ZSTD_c_windowLog, window_log(encoder->level, size), r);
    return ZSTD_isError(r) ? r : ZSTD_compress2(cctx, dst, dst_size, src, size);
}

zt_result zt__encode_frame(zt__encoder *encoder, const void *src, size_t size, void *dst, size_t dst_size,
                           size_t *frame_size, zt_diag *diag) {
    *frame_size = 0;
    size_t got = compress(encoder, src, size, dst, dst_size);
    if (ZSTD_isError(got)) {
        bool memory = ZSTD_getErrorCode(got) == ZSTD_error_memory_allocation;
        return zt__fail(diag, memory ? ZT_NO_MEMORY : ZT_INTERNAL, 0, ZT__NO_OFFSET, "zstd could not compress: %s",
                        ZSTD_getErrorName(got));
    }
    /* Another zstd may choose otherwise some day: what a reader would refuse is not written. */
    zt__sink quiet = {0};
    if (got < size && zt__check_frame(&quiet, dst, got, size, ZT__NO_OFFSET) == ZT_OK)
        *frame_size = got;
    return ZT_OK;
}

zt_result zt__encode_stored(zt__encoder *encoder, const void *src, size_t size, void *dst, size_t dst_size,
                            uint8_t *codec, size_t *stored_size, zt_diag *diag) {
    return zt__encode_tile(encoder, ZT__PRED_MAX_EFFORT, NULL, src, size, dst, dst_size, codec, stored_size, diag);
}

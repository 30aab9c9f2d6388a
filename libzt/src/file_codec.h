/* SPDX-License-Identifier: Apache-2.0 */
/* Codecs (spec/ztex.md section 6): the zstd profile, planes, tiles. */
#ifndef ZT_FILE_CODEC_H
#define ZT_FILE_CODEC_H

#include "base_diag.h"
#include "base_memory.h"
#include "file_geometry.h"
#include "file_layout.h"

/* A decoding context: one for each thread. Memory is taken once and reused. Zero-initialised is empty. */
typedef struct zt__decoder {
    zt__memory *memory;
    void *zstd; /* workspace of the static ZSTD_DCtx */
    size_t zstd_size;
    void *stored; /* buffer for stored bytes */
    uint64_t stored_size;
    void *raw; /* buffer for decoded bytes */
    uint64_t raw_size;
    const zt__pred_kernel *kernel; /* of codec 2 */
    void *scratch;                 /* of codecs 2 and 4 */
    uint64_t scratch_size;
} zt__decoder;

void zt__decoder_init(zt__decoder *decoder, zt__memory *memory);
void zt__decoder_free(zt__decoder *decoder);
/* Buffers of at least size bytes, kept until the next call. */
zt_result zt__decoder_stored(zt__decoder *decoder, uint64_t size, zt_diag *diag, uint8_t **out);
zt_result zt__decoder_raw(zt__decoder *decoder, uint64_t size, zt_diag *diag, uint8_t **out);

/* Takes scratch memory of at least size bytes, if it is there. */
void zt__decoder_reserve(zt__decoder *decoder, uint64_t size);

/* The five decoding functions below fail also with the validator's sink when dst could not be filled, after reporting
 * why: the result is then ZT_CORRUPT while sink->stopped is ZT_OK, and the caller goes on with the next tile or chunk.
 * A wrong hash alone is no failure there. */

/* Rules 5001 to 5003. */
zt_result zt__check_frame(zt__sink *sink, const uint8_t *frame, size_t size, uint64_t decoded_size, uint64_t offset);

/* Rules 5001 to 5004: decodes a frame into exactly dst_size bytes. */
zt_result zt__decode_frame(zt__sink *sink, zt__decoder *decoder, const uint8_t *frame, size_t size, void *dst,
                           size_t dst_size, uint64_t offset);

/* Decodes stored bytes of a chunk or tile by codec (raw or zstd). hash: of the decoded bytes; rule: the number for a
 * wrong one (4004, 5203). */
zt_result zt__decode_stored(zt__sink *sink, zt__decoder *decoder, uint8_t codec, const uint8_t *stored, size_t size,
                            void *dst, size_t dst_size, uint64_t hash, uint32_t hash_rule, uint64_t offset);

/* Decodes a tile of codec 2 (rules 5302 to 5313, 5001 to 5004, 5203) into rows that begin pitch bytes apart. */
zt_result zt__decode_pred(zt__sink *sink, zt__decoder *decoder, const zt__pred_shape *shape, const uint8_t *stored,
                          size_t size, uint8_t *dst, size_t pitch, uint64_t hash, uint64_t offset);

/* Decodes a tile of codec 4 (rules 5001 to 5004, 5203): row_count rows of row_size bytes. */
zt_result zt__decode_fields(zt__sink *sink, zt__decoder *decoder, const zt__fields *fields, size_t row_size,
                            size_t row_count, const uint8_t *stored, size_t size, uint8_t *dst, size_t pitch,
                            uint64_t hash, uint64_t offset);

/* Reads one plane from the cursor (rules 5101 to 5105) into count elements of element_size bytes in the machine's byte
 * order; dst must be aligned for them. chunk_offset: of the cursor's first byte in the file. */
zt_result zt__decode_plane(zt__sink *sink, zt__decoder *decoder, zt__cursor *in, uint64_t chunk_offset,
                           uint32_t element_size, uint32_t count, void *dst);

/* The same of its header alone (rules 5101 to 5103): for counts to be judged before there is memory for them. */
zt_result zt__skip_plane(zt__sink *sink, zt__cursor *in, uint64_t chunk_offset, uint32_t element_size, uint32_t count);

/* An encoding context: one for each thread. */
typedef struct zt__encoder {
    zt__memory *memory;
    void *zstd; /* ZSTD_CCtx with custom allocation through memory */
    int level;  /* 1 to 19 */
    bool raw_only;
    void *pred; /* work memory of tiles */
    uint64_t pred_size;
} zt__encoder;

/* The zstd level of an effort, 1 to 9, for what is not a tile of texels. */
int zt__level_of_effort(uint32_t effort);

zt_result zt__encoder_init(zt__encoder *encoder, zt__memory *memory, int level, bool raw_only, zt_diag *diag);
void zt__encoder_free(zt__encoder *encoder);

/* Most bytes that encoding size bytes may need in dst while trying. */
size_t zt__encode_bound(size_t size);

/* One frame of the profile; *frame_size is 0 when it would not be smaller than the source. dst_size at least
 * zt__encode_bound(size). */
zt_result zt__encode_frame(zt__encoder *encoder, const void *src, size_t size, void *dst, size_t dst_size,
                           size_t *frame_size, zt_diag *diag);

/* Codes bytes with the codec that makes them smallest (the raw codec on a tie): *codec, and *stored_size bytes in dst.
 * dst_size at least zt__encode_bound(size). */
zt_result zt__encode_stored(zt__encoder *encoder, const void *src, size_t size, void *dst, size_t dst_size,
                            uint8_t *codec, size_t *stored_size, zt_diag *diag);

/* Memory of at least size bytes, kept until the next call of this or zt__encode_tile. */
zt_result zt__encoder_memory(zt__encoder *encoder, uint64_t size, zt_diag *diag, uint8_t **out);

/* The same for a tile of a level (file_effort.c) with the codecs that its form allows; form may be NULL. effort: 1
 * (fast) to 9 (small). The same bytes on every machine. */
zt_result zt__encode_tile(zt__encoder *encoder, uint32_t effort, const zt__tile_form *form, const void *src,
                          size_t size, void *dst, size_t dst_size, uint8_t *codec, size_t *stored_size, zt_diag *diag);

/* Most bytes of a plane with its header. */
size_t zt__plane_bound(uint32_t element_size, uint32_t count);

/* Codes count elements in the machine's byte order as the smallest of all plane forms (in the order of the
 * specification on a tie) and appends header and bytes at dst. scratch: at least 2 x element_size x count bytes. */
zt_result zt__encode_plane(zt__encoder *encoder, uint32_t element_size, uint32_t count, const void *src, void *scratch,
                           uint8_t *dst, size_t dst_size, size_t *used, zt_diag *diag);

/* A chunk that is a header and planes, on its way. */
typedef struct zt__plane_writer {
    zt__encoder *encoder;
    zt_diag *diag;
    uint8_t *out; /* the header is the caller's to write */
    uint64_t capacity;
    size_t used;
    void *scratch;
    uint64_t scratch_size;
} zt__plane_writer;

/* capacity: of header and planes; largest: bytes of the largest plane. Whatever begins is ended. */
zt_result zt__planes_begin(zt__plane_writer *w, zt__encoder *encoder, size_t header_size, uint64_t capacity,
                           uint64_t largest, zt_diag *diag);
zt_result zt__planes_put(zt__plane_writer *w, uint32_t element_size, uint32_t count, const void *src);
/* Hands the chunk over, or frees it when result is an error; returns result. */
zt_result zt__planes_end(zt__plane_writer *w, zt_result result, uint8_t **out, uint64_t *out_capacity,
                         size_t *out_size);

#endif

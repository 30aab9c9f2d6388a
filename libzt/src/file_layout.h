/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The fixed structures of the container (spec/ztex.md sections 3 to 9). One function for each structure reads and
 * writes it: a zt__coder is either a cursor or a buffer.
 */
#ifndef ZT_FILE_LAYOUT_H
#define ZT_FILE_LAYOUT_H

#include "base_bytes.h"
#include "file_geometry.h"

enum {
    ZT__PREAMBLE_SIZE = 64,
    ZT__ENTRY_SIZE = 48,
    ZT__HEAD_SIZE = 64,
    ZT__IMAGE_RECORD_SIZE = 32,
    ZT__UNIT_RECORD_SIZE = 24,
    ZT__TILE_RECORD_SIZE = 16,
    ZT__TEXTURE_ENTRY_SIZE = 16,
    ZT__LAYER_ENTRY_SIZE = 8,
    ZT__PLANE_HEADER_SIZE = 32
};

enum {
    ZT__CODEC_RAW = 0,
    ZT__CODEC_ZSTD = 1,
    ZT__CODEC_PRED = 2,  /* tiles of levels */
    ZT__CODEC_FIELDS = 4 /* the same */
};

enum { ZT__FLAG_CRITICAL = 1, ZT__FLAG_SAFE_TO_COPY = 2 };

extern const uint8_t zt__magic[10];
extern const uint8_t zt__head_magic[8];

#define ZT__TYPE(a, b, c, d) ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)
#define ZT__TEXS ZT__TYPE('T', 'E', 'X', 'S')
#define ZT__IMAG ZT__TYPE('I', 'M', 'A', 'G')
#define ZT__ZPMP ZT__TYPE('Z', 'P', 'M', 'P')
#define ZT__SLMP ZT__TYPE('S', 'L', 'M', 'P')
#define ZT__UMBR ZT__TYPE('U', 'M', 'B', 'R')
#define ZT__META ZT__TYPE('M', 'E', 'T', 'A')
#define ZT__TEXL ZT__TYPE('T', 'E', 'X', 'L')

/* What is known of a chunk type; NULL for unknown ones. rank orders the file (R3009). */
typedef struct zt__chunk_type {
    uint32_t type;
    uint16_t version;
    uint8_t flags;
    bool compressible;
    bool repeats;
    bool required;
    uint8_t rank; /* unknown types: ZT__RANK_UNKNOWN */
    uint8_t kind; /* of the textures whose payload this is; ZT_KIND_IMAGE: it is none */
} zt__chunk_type;

enum { ZT__RANK_UNKNOWN = 6 };

const zt__chunk_type *zt__find_chunk_type(uint32_t type);
/* The i-th row of the table, NULL behind the last. */
const zt__chunk_type *zt__get_chunk_type(uint32_t i);
/* The row of the payloads of a kind of textures; NULL: they have none. */
const zt__chunk_type *zt__find_payload_type(uint8_t kind);

/* Reads from or writes to a fixed structure, by a flag. */
typedef struct zt__coder {
    uint8_t *out;   /* writing: next byte; NULL when reading */
    zt__cursor *in; /* reading */
} zt__coder;

typedef struct zt__preamble {
    uint8_t magic[10];
    uint16_t major, minor, reserved0;
    uint64_t file_size;
    uint32_t directory_size, chunk_count;
    uint64_t required_features, reserved1, reserved2, directory_hash;
} zt__preamble;

typedef struct zt__entry {
    uint32_t type;
    uint16_t version;
    uint8_t flags, codec;
    uint64_t offset, stored_size, decoded_size, stored_hash, decoded_hash;
} zt__entry;

typedef struct zt__head {
    uint8_t magic[8];
    uint32_t index, reserved;
    zt__entry entry;
} zt__head;

typedef struct zt__unit_record {
    uint64_t offset, size, index_hash;
} zt__unit_record;

typedef struct zt__tile_record {
    uint32_t stored_size;
    uint8_t codec;
    uint8_t reserved[3];
    uint64_t hash;
} zt__tile_record;

typedef struct zt__texture_entry {
    uint8_t kind, wrap_u, wrap_v, wrap_w;
    uint32_t layer_count, name_size, reserved;
} zt__texture_entry;

typedef struct zt__layer_entry {
    uint16_t semantic, reserved;
    uint32_t image;
} zt__layer_entry;

typedef struct zt__plane_header {
    uint8_t element_size, predictor, packing, codec, bit_width;
    uint8_t reserved[3];
    uint64_t base;
    uint32_t count, stored_size;
    uint64_t hash;
} zt__plane_header;

void zt__code_preamble(zt__coder *coder, zt__preamble *p);
void zt__code_entry(zt__coder *coder, zt__entry *e);
void zt__code_head(zt__coder *coder, zt__head *h);
void zt__code_image(zt__coder *coder, zt__image_record *r);
void zt__code_unit(zt__coder *coder, zt__unit_record *u);
void zt__code_tile(zt__coder *coder, zt__tile_record *t);
void zt__code_texture(zt__coder *coder, zt__texture_entry *t);
void zt__code_layer(zt__coder *coder, zt__layer_entry *l);
void zt__code_plane(zt__coder *coder, zt__plane_header *p);
void zt__code_u8(zt__coder *coder, uint8_t *v);
void zt__code_u32(zt__coder *coder, uint32_t *v);
void zt__code_u64(zt__coder *coder, uint64_t *v);

static inline zt__coder zt__reading(zt__cursor *in) {
    zt__coder c = {NULL, in};
    return c;
}

static inline zt__coder zt__writing(uint8_t *out) {
    zt__coder c = {out, NULL};
    return c;
}

#endif
